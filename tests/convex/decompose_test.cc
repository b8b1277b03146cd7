#include "deepslam/convex/decompose.h"

#include <algorithm>
#include <array>
#include <random>

#include <gtest/gtest.h>

#include "convex/convex_samples.h"
#include "deepslam/convex/convex_hull.h"
#include "deepslam/convex/mass_properties.h"
#include "deepslam/shape/mesh_check.h"

namespace deepslam::convex {
namespace {

using testing_support::BoxMesh;

double VolumeOf(const std::vector<TriangleMesh>& pieces) {
  double sum = 0;
  for (const TriangleMesh& piece : pieces) sum += convex::VolumeOf(piece);
  return sum;
}

bool Holds(const TriangleMesh& convex, const Eigen::Vector3f& p) {
  return std::all_of(convex.faces.begin(), convex.faces.end(), [&](const auto& face) {
    const Eigen::Vector3f a = convex.vertices[face[0]];
    return (convex.vertices[face[1]] - a).cross(convex.vertices[face[2]] - a).dot(p - a) <= 1e-7F;
  });
}

bool AnyHolds(const std::vector<TriangleMesh>& pieces, const Eigen::Vector3f& p) {
  return std::any_of(
      pieces.begin(), pieces.end(), [&](const TriangleMesh& piece) { return Holds(piece, p); });
}

TEST(Decompose, ABoxIsOnePiece) {
  const std::vector<TriangleMesh> pieces = Decompose(BoxMesh({0, 0, 0}, {1, 2, 0.5F}), {});
  ASSERT_EQ(pieces.size(), 1U);
  EXPECT_NEAR(VolumeOf(pieces), 1.0, 1e-3);
}

TEST(Decompose, ATableLeavesTheRoomUnderItsTop) {
  const std::vector<TriangleMesh> pieces = Decompose(testing_support::TableMesh(), {});
  EXPECT_NEAR(VolumeOf(pieces) / testing_support::kTableM3, 1, 0.1);
  EXPECT_TRUE(AnyHolds(pieces, {0, 0, 0.73F})) << "the top";
  for (const float x : {-0.525F, 0.525F}) {
    for (const float y : {-0.325F, 0.325F}) EXPECT_TRUE(AnyHolds(pieces, {x, y, 0.35F})) << "a leg";
  }
  for (const float x : {-0.4F, 0.0F, 0.4F}) {
    for (const float z : {0.1F, 0.4F, 0.65F})
      EXPECT_FALSE(AnyHolds(pieces, {x, 0, z})) << "a ball rolls there";
  }
}

TEST(Decompose, PiecesWithinASolidBodyKeepTheirCorners) {
  // Steps above and below: cuts along them meet within the body, where the surface has no point.
  // Heights are sums of one along x and one along y, so that no two columns touch at an edge alone.
  constexpr int kSide = 6;
  std::mt19937 random(7);
  const auto steps = [&] {
    std::array<int, kSide> heights{};
    for (int& height : heights) height = static_cast<int>(random() % 4);
    return heights;
  };
  for (int body = 0; body < 5; ++body) {
    const auto foot_x = steps(), foot_y = steps(), top_x = steps(), top_y = steps();
    std::vector<std::vector<testing_support::Column>> columns(kSide);
    double volume_m3 = 0;
    for (int x = 0; x < kSide; ++x) {
      for (int y = 0; y < kSide; ++y) {
        const testing_support::Column column{.foot = foot_x[x] + foot_y[y],
                                             .top = 12 + top_x[x] + top_y[y]};
        columns[x].push_back(column);
        volume_m3 += 1e-3 * (column.top - column.foot);
      }
    }
    const TriangleMesh mesh = testing_support::ColumnsMesh(columns);
    ASSERT_NEAR(convex::VolumeOf(mesh), volume_m3, 1e-5);
    EXPECT_NEAR(VolumeOf(Decompose(mesh, {})) / volume_m3, 1, 0.1) << body;
  }
}

TEST(Decompose, PiecesAreConvexClosedAndBounded) {
  const DecomposeOptions few{.max_pieces = 3};
  EXPECT_LE(Decompose(testing_support::TableMesh(), few).size(), 3U);
  for (const TriangleMesh& piece : Decompose(testing_support::TableMesh(), {})) {
    EXPECT_TRUE(shape::CheckMesh(piece).ok()) << shape::CheckMesh(piece).fault;
    EXPECT_LE(piece.vertices.size(), 64U);
    EXPECT_NEAR(convex::VolumeOf(ConvexHull(piece.vertices)), convex::VolumeOf(piece), 1e-7);
  }
}

TEST(Decompose, IsTheSameEveryTime) {
  const std::vector<TriangleMesh> one = Decompose(testing_support::TableMesh(), {});
  const std::vector<TriangleMesh> other = Decompose(testing_support::TableMesh(), {});
  ASSERT_EQ(one.size(), other.size());
  for (std::size_t n = 0; n < one.size(); ++n) {
    EXPECT_EQ(one[n].vertices, other[n].vertices);
    EXPECT_EQ(one[n].faces, other[n].faces);
  }
}

TEST(Decompose, OfWhatHasNoInside) {
  EXPECT_TRUE(Decompose({}, {}).empty());
  TriangleMesh open = BoxMesh({0, 0, 0}, {1, 1, 1});
  open.faces.pop_back();
  const std::vector<TriangleMesh> hull = Decompose(open, {});
  ASSERT_EQ(hull.size(), 1U);
  EXPECT_NEAR(VolumeOf(hull), 1, 1e-6);
  TriangleMesh flat;
  flat.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  flat.faces = {{0, 1, 2}};
  EXPECT_TRUE(Decompose(flat, {}).empty());
}

}  // namespace
}  // namespace deepslam::convex
