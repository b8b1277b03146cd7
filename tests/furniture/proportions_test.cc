#include "deepslam/furniture/proportions.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "deepslam/scene/mesh_box.h"
#include "deepslam/shape/small_components.h"
#include "deepslam/shape/stretch.h"
#include "furniture/design_shapes.h"

namespace deepslam::furniture {
namespace {

TriangleMesh MakeMesh(Kind kind, std::uint64_t number) {
  return MakeMesh(kind, number, "proportions test");
}

double Area(const TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& face : mesh.faces) {
    const Eigen::Vector3d a = mesh.vertices[face[0]].cast<double>();
    sum += 0.5 * (mesh.vertices[face[1]].cast<double>() - a)
                     .cross(mesh.vertices[face[2]].cast<double>() - a)
                     .norm();
  }
  return sum;
}

TEST(Bend, KeepsTheEndsAndTheOrder) {
  const Bend bend{0.3F, 0.6F};
  EXPECT_FLOAT_EQ(bend(0), 0);
  EXPECT_FLOAT_EQ(bend(1), 1);
  EXPECT_FLOAT_EQ(bend(0.3F), 0.6F);
  for (int n = 0; n < 100; ++n)
    EXPECT_LT(bend(static_cast<float>(n) / 100), bend(static_cast<float>(n + 1) / 100));
}

TEST(Proportions, OfTheirOwnLeaveTheSurface) {
  for (const Kind kind : {Kind::kChair, Kind::kSofa, Kind::kRoundTable}) {
    const TriangleMesh mesh = MakeMesh(kind, 1);
    const TriangleMesh same = Reproportion(mesh, Proportions{});
    EXPECT_GT(same.faces.size(), mesh.faces.size());
    EXPECT_NEAR(Area(same), Area(mesh), 1e-3 * Area(mesh));
    EXPECT_TRUE(BoxOfFaces(same).sizes().isApprox(BoxOfFaces(mesh).sizes(), 1e-5F));
    EXPECT_GE(shape::GridIntersectionOverUnion(ShapeOf(same), ShapeOf(mesh)), 0.99);
  }
}

TEST(Proportions, MoveWhatLiesInTheMiddle) {
  TriangleMesh column;  // a strip standing upright along z, a tenth of it a step
  for (std::uint32_t n = 0; n <= 10; ++n) {
    const float z = static_cast<float>(n) / 10;
    column.vertices.emplace_back(0.0F, -0.01F, z);
    column.vertices.emplace_back(0.0F, 0.01F, z);
    if (n == 0) continue;
    column.faces.push_back({2 * n - 2, 2 * n - 1, 2 * n});
    column.faces.push_back({2 * n - 1, 2 * n + 1, 2 * n});
  }
  Proportions proportions;
  proportions.height = {0.4F, 0.6F};
  proportions.lean = 0.5F;
  float behind = 0;
  for (const Eigen::Vector3f& place : Reproportion(column, proportions).vertices) {
    EXPECT_NEAR(place.x(), -0.5F * std::max(0.0F, place.z() - 0.6F), 1e-5);
    behind = std::min(behind, place.x());
  }
  EXPECT_NEAR(behind, -0.2F, 1e-5);
}

// Neighbours are divided alike and moved alike.
TEST(Proportions, KeepPartsTogetherAndBothSidesAlike) {
  for (const Kind kind : {Kind::kChair, Kind::kOfficeChair, Kind::kSofa, Kind::kDesk}) {
    for (std::uint64_t n = 0; n < 12; ++n) {
      const TriangleMesh mesh = MakeMesh(kind, n);
      Random random(3, KindName(kind), n);
      const Proportions proportions = DrawProportions(true, random);
      const VoxelGrid remade = ShapeOf(Reproportion(mesh, proportions));
      std::size_t largest = 0;
      std::size_t all = 0;
      for (const auto& part : shape::PartsOf(remade, 1)) {
        largest = std::max(largest, part.size());
        all += part.size();
      }
      EXPECT_GE(static_cast<double>(largest), 0.97 * static_cast<double>(all))
          << KindName(kind) << " " << n;

      TriangleMesh mirrored = mesh;
      for (Eigen::Vector3f& place : mirrored.vertices) place.y() *= -1;
      TriangleMesh back = Reproportion(mirrored, proportions);
      for (Eigen::Vector3f& place : back.vertices) place.y() *= -1;
      EXPECT_GE(shape::GridIntersectionOverUnion(remade, ShapeOf(back)), 0.95)
          << KindName(kind) << " " << n;
    }
  }
}

TEST(Proportions, DifferByTheDrawAndOnlyByIt) {
  const TriangleMesh mesh = MakeMesh(Kind::kChair, 2);
  const VoxelGrid before = ShapeOf(mesh);
  double sum = 0;
  for (std::uint64_t n = 0; n < 10; ++n) {
    Random random(3, "draw", n);
    Random again(3, "draw", n);
    const TriangleMesh a = Reproportion(mesh, DrawProportions(true, random));
    const TriangleMesh b = Reproportion(mesh, DrawProportions(true, again));
    EXPECT_EQ(a.vertices, b.vertices);
    sum += shape::GridIntersectionOverUnion(before, ShapeOf(a));
  }
  EXPECT_LT(sum / 10, 0.6) << "thin parts of other designs do not meet";
}

TEST(Proportions, WithoutABackNothingLeans) {
  for (std::uint64_t n = 0; n < 50; ++n) {
    Random random(3, "straight", n);
    const Proportions drawn = DrawProportions(false, random);
    EXPECT_EQ(drawn.lean, 0);
    EXPECT_EQ(drawn.taper, 0);
  }
}

TEST(Proportions, OfNothingAreNothing) {
  Proportions proportions;
  proportions.lean = 0.2F;
  EXPECT_TRUE(Reproportion({}, proportions).empty());
}

TEST(Proportions, KeepColours) {
  TriangleMesh mesh = MakeMesh(Kind::kStool, 1);
  mesh.colours.assign(mesh.vertices.size(), Rgb8{10, 20, 30});
  const TriangleMesh remade = Reproportion(mesh, Proportions{});
  ASSERT_EQ(remade.colours.size(), remade.vertices.size());
  EXPECT_TRUE(std::all_of(remade.colours.begin(), remade.colours.end(), [](const Rgb8& colour) {
    return colour == Rgb8{10, 20, 30};
  }));
}

}  // namespace
}  // namespace deepslam::furniture
