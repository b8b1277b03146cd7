#include "deepslam/mesh/slab.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "deepslam/core/random.h"
#include "deepslam/mesh/check_mesh.h"

namespace deepslam::mesh {
namespace {

Slab Wall() { return {0, 4, 0, 2.5, 0.06, {}, 0.5}; }

TEST(MakeSlab, IsAClosedBoxWithItsFaceInFront) {
  const TriangleMesh mesh = MakeSlab(Wall());
  const MeshCheck check = CheckMesh(mesh);
  EXPECT_TRUE(check.ok()) << check.fault;
  EXPECT_NEAR(check.volume_m3, 4 * 2.5 * 0.06, 1e-6);
  for (const Eigen::Vector3f& p : mesh.vertices) {
    EXPECT_LE(p.y(), 0);
    EXPECT_GE(p.y(), -0.06F);
  }
}

TEST(MakeSlab, HasHolesWhereOpeningsAre) {
  Slab slab = Wall();
  slab.holes = {{0.5, 1.4, -0.2, 2.0},  // a door that reaches below
                {2, 3.2, 0.9, 2.1},     // a window
                {3.8, 9, 0, 9}};        // a passage at the end, up to the ceiling
  const MeshCheck check = CheckMesh(MakeSlab(slab));
  EXPECT_TRUE(check.ok()) << check.fault;
  EXPECT_NEAR(check.volume_m3, (4 * 2.5 - 0.9 * 2.0 - 1.2 * 1.2 - 0.2 * 2.5) * 0.06, 1e-6);
  EXPECT_EQ(check.num_components, 1);
  slab.holes = {{1, 2, -1, 9}};
  EXPECT_EQ(CheckMesh(MakeSlab(slab)).num_components, 2);
}

// Any holes at all: what is left is closed, and as large as it should be where no cell was filled.
TEST(MakeSlab, IsClosedWhateverItsHoles) {
  Random random(3);
  for (int n = 0; n < 200; ++n) {
    Slab slab = Wall();
    slab.step_m = random.Uniform(0.2, 2);
    const int num_holes = static_cast<int>(random.Uniform(0, 6));
    for (int hole = 0; hole < num_holes; ++hole) {
      // Whole quarters, so that holes touch and overlap.
      const auto quarter = [&](double most) { return 0.25 * std::floor(random.Uniform(-1, most)); };
      const double left = quarter(16);
      const double bottom = quarter(10);
      slab.holes.push_back({left, left + quarter(8), bottom, bottom + quarter(8)});
    }
    const TriangleMesh mesh = MakeSlab(slab);
    if (mesh.empty()) continue;
    const MeshCheck check = CheckMesh(mesh);
    EXPECT_TRUE(check.ok()) << n << ": " << check.fault;
  }
}

TEST(MakeSlab, OfNoSizeIsEmpty) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Slab& slab : {Slab{0, 0, 0, 2, 0.06, {}, 0.5},
                           Slab{0, 4, 2, 1, 0.06, {}, 0.5},
                           Slab{0, 4, 0, 2, 0, {}, 0.5},
                           Slab{0, nan, 0, 2, 0.06, {}, 0.5},
                           Slab{0, 4, 0, 2, 0.06, {}, 0},
                           Slab{0, 4, 0, 2, 0.06, {{-1, 5, -1, 5}}, 0.5}})
    EXPECT_TRUE(MakeSlab(slab).empty());
}

// A measured wall at y = 0 of the slab, red on its left half and blue on the right.
TriangleMesh Measured(const Pose3& world_from_slab) {
  TriangleMesh mesh;
  for (int i = 0; i <= 80; ++i) {
    for (int k = 0; k <= 50; ++k) {
      const Eigen::Vector3d p(0.05 * i, 0.01, 0.05 * k);
      mesh.vertices.push_back((world_from_slab * p).cast<float>());
      mesh.colours.push_back(p.x() < 2 ? Rgb8{200, 0, 0} : Rgb8{0, 0, 200});
    }
  }
  mesh.faces.push_back({0, 1, 2});
  return mesh;
}

TEST(ColourSlab, TakesTheColoursOfTheSurfaceBeforeIt) {
  const Pose3 place{Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ())),
                    {5, -2, 0}};
  Slab slab = Wall();
  slab.step_m = 0.1;
  TriangleMesh mesh = MakeSlab(slab);
  ColourSlab(Measured(place), place, {}, mesh);
  ASSERT_EQ(mesh.colours.size(), mesh.vertices.size());
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (mesh.vertices[v].y() < 0 || std::abs(mesh.vertices[v].x() - 2) < 0.15F) continue;
    const Rgb8 expected = mesh.vertices[v].x() < 2 ? Rgb8{200, 0, 0} : Rgb8{0, 0, 200};
    EXPECT_EQ(mesh.colours[v], expected) << mesh.vertices[v].transpose();
  }
}

TEST(ColourSlab, StaysPlainWhereNothingWasSeen) {
  TriangleMesh mesh = MakeSlab(Wall());
  ColourSlab(Measured({Eigen::Quaterniond::Identity(), {0, 3, 0}}), {}, {}, mesh);
  EXPECT_TRUE(mesh.colours.empty());
  ColourSlab({}, {}, {}, mesh);
  EXPECT_TRUE(mesh.colours.empty());
}

TEST(MakePrism, IsClosedAndAsLargeAsItsOutline) {
  const std::vector<Eigen::Vector2d> outline = {{0, 0}, {4, 0}, {4, 3}, {2, 3}, {2, 1}, {0, 1}};
  const Result<TriangleMesh> prism = MakePrism(outline, 0.1);
  ASSERT_TRUE(prism.ok());
  const MeshCheck check = CheckMesh(*prism);
  EXPECT_TRUE(check.ok()) << check.fault;
  EXPECT_NEAR(check.volume_m3, 0.8, 1e-6);
}

TEST(MakePrism, RefusesWhatIsNoPolygon) {
  EXPECT_FALSE(MakePrism(std::vector<Eigen::Vector2d>{{0, 0}, {1, 0}}, 0.1).ok());
  EXPECT_FALSE(MakePrism(std::vector<Eigen::Vector2d>{{0, 0}, {2, 2}, {2, 0}, {0, 2}}, 0.1).ok());
}

}  // namespace
}  // namespace deepslam::mesh
