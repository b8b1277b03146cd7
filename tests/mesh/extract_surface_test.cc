#include "deepslam/mesh/extract_surface.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "deepslam/core/random.h"
#include "deepslam/mesh/check_mesh.h"
#include "deepslam/mesh/surface_distance.h"
#include "support/voxel_shapes.h"

namespace deepslam::mesh {
namespace {

using namespace testing_support;  // NOLINT(google-build-using-namespace)

constexpr double kVoxelVolume = kVoxelSize * kVoxelSize * kVoxelSize;
constexpr double kCornerShift = 0.8660254037844386 * kVoxelSize;  // half a voxel along every axis

TriangleMesh Extract(const VoxelGrid& grid) {
  Result<TriangleMesh> mesh = ExtractSurface(grid, {});
  EXPECT_TRUE(mesh.ok());
  return mesh.ok() ? *mesh : TriangleMesh();
}

TriangleMesh BareBoundary(const VoxelGrid& grid) {
  SurfaceOptions options;
  options.iterations = 0;
  return *ExtractSurface(grid, options);
}

struct Shape {
  const char* name;
  VoxelGrid (*make)();
  int num_components;
  double volume_tolerance;  // share; thin shapes lose more at their edges
};

class ExtractSurfaceOf : public ::testing::TestWithParam<Shape> {};

TEST_P(ExtractSurfaceOf, IsClosedOrientedManifoldNearTheVoxels) {
  const VoxelGrid grid = GetParam().make();
  const TriangleMesh mesh = Extract(grid);
  const MeshCheck check = CheckMesh(mesh);
  EXPECT_TRUE(check.ok()) << check.fault;
  EXPECT_FALSE(SelfIntersects(mesh));
  EXPECT_EQ(check.num_components, GetParam().num_components);
  EXPECT_LE(SurfaceDistance(mesh, BareBoundary(grid)), kCornerShift * 1.001);
  const double voxels = CountOccupied(grid) * kVoxelVolume;
  EXPECT_NEAR(check.volume_m3 / voxels, 1.0, GetParam().volume_tolerance);
}

VoxelGrid TwoBalls() {
  return FillGrid([](double x, double y, double z) {
    return std::hypot(std::hypot(x - 15, y), z) < 9 || std::hypot(std::hypot(x + 15, y), z) < 9;
  });
}

VoxelGrid OneVoxel() {
  VoxelGrid grid;
  grid.occupied[VoxelGrid::Index(10, 20, 30)] = 1;
  return grid;
}

INSTANTIATE_TEST_SUITE_P(
    Shapes,
    ExtractSurfaceOf,
    ::testing::Values(Shape{"Sphere", [] { return Sphere(14); }, 1, 0.02},
                      Shape{"Box", [] { return Box(20, 12, 8); }, 1, 0.04},
                      Shape{"Chair", ChairWithThinLegs, 1, 0.06},
                      Shape{"Table", RoundTable, 1, 0.06},
                      Shape{"TwoParts", TwoBalls, 2, 0.04},
                      Shape{"OneVoxel", OneVoxel, 1, 0.6},
                      Shape{"FullGrid", [] { return Box(40, 40, 40); }, 1, 0.05}),
    [](const auto& shape) { return std::string(shape.param.name); });

TEST(ExtractSurface, KeepsOneVoxelLegsAtMostOfTheirWidth) {
  const TriangleMesh mesh = Extract(ChairWithThinLegs());
  // Cross-sections of the leg at (12.5, 12.5) halfway down: vertices within two voxels of its axis.
  double min_x = 1e9;
  double max_x = -1e9;
  for (const Eigen::Vector3f& p : mesh.vertices) {
    const Eigen::Vector3d v = p.cast<double>() / kVoxelSize;
    if (v.z() > -15 || v.z() < -17 || std::abs(v.x() - 12.5) > 2 || std::abs(v.y() - 12.5) > 2)
      continue;
    min_x = std::min(min_x, v.x());
    max_x = std::max(max_x, v.x());
  }
  EXPECT_GE(max_x - min_x, 0.7);
  EXPECT_LE(max_x - min_x, 1.3);
}

TEST(ExtractSurface, FlattensTheStairsOfATiltedPlane) {
  // The upper side of a wedge that rises one voxel in five: its stairs are a voxel high, half a
  // voxel to either side.
  const double slope = 0.2;
  const VoxelGrid grid = FillGrid([=](double x, double y, double z) {
    return std::abs(x) < 25 && std::abs(y) < 15 && z > -20 && z < slope * x;
  });
  const auto rms = [&](const TriangleMesh& mesh) {
    double squared = 0;
    int count = 0;
    for (const Eigen::Vector3f& p : mesh.vertices) {
      const Eigen::Vector3d v = p.cast<double>() / kVoxelSize;
      // Away from the wedge's edges, which are rounded.
      if (std::abs(v.x()) > 19 || std::abs(v.y()) > 9 || v.z() < -8) continue;
      const double off = v.z() - slope * v.x();
      squared += off * off;
      ++count;
    }
    return std::sqrt(squared / count);
  };
  EXPECT_LT(rms(Extract(grid)), 0.4 * rms(BareBoundary(grid)));
}

// Of a top of 28 x 62 voxels and that thickness, along whose rim a third of the voxels is missing.
double FarthestFromTop(int thickness) {
  constexpr int kTop = 42;
  VoxelGrid grid;
  Random random(3);
  for (int i = 18; i < 46; ++i) {
    for (int j = 1; j < 63; ++j) {
      const bool is_rim = i == 18 || i == 45 || j == 1 || j == 62;
      if (is_rim && random.Uniform() < 0.3) continue;
      for (int k = kTop - thickness; k < kTop; ++k) grid.occupied[VoxelGrid::Index(i, j, k)] = 1;
    }
  }
  double farthest = 0;
  for (const Eigen::Vector3f& p : Extract(grid).vertices) {
    const double off = (p.z() + 0.5) / kVoxelSize - kTop;
    if (off > -0.7) farthest = std::max(farthest, std::abs(off));
  }
  return farthest;
}

TEST(ExtractSurface, KeepsTopsFlatUpToTheirRims) {
  for (const int thickness : {1, 2, 12}) EXPECT_LT(FarthestFromTop(thickness), 1e-4) << thickness;
}

TEST(ExtractSurface, KeepsTheEdgesOfBoxes) {
  const VoxelGrid grid = Box(20, 12, 8);
  EXPECT_LT(SurfaceDistance(Extract(grid), BareBoundary(grid)), 1e-4 * kVoxelSize);
}

TEST(ExtractSurface, FillsCavitiesAndDropsSpecks) {
  VoxelGrid grid = FillGrid([](double x, double y, double z) {
    const double outer = std::max({std::abs(x), std::abs(y), std::abs(z)});
    return outer < 20 && outer > 15;
  });
  grid.occupied[VoxelGrid::Index(1, 1, 1)] = 1;
  const MeshCheck check = CheckMesh(Extract(grid));
  EXPECT_EQ(check.num_components, 1);
  EXPECT_NEAR(check.volume_m3 / (40.0 * 40 * 40 * kVoxelVolume), 1.0, 0.04);
}

TEST(ExtractSurface, MakesAManifoldOfVoxelsThatTouchInEdgesAndCorners) {
  VoxelGrid edge;
  edge.occupied[VoxelGrid::Index(10, 10, 10)] = 1;
  edge.occupied[VoxelGrid::Index(11, 11, 10)] = 1;
  VoxelGrid corner;
  corner.occupied[VoxelGrid::Index(10, 10, 10)] = 1;
  corner.occupied[VoxelGrid::Index(11, 11, 11)] = 1;
  for (const VoxelGrid& grid : {edge, corner}) {
    const MeshCheck check = CheckMesh(Extract(grid));
    EXPECT_TRUE(check.ok()) << check.fault;
    EXPECT_EQ(check.num_components, 1);
  }
  for (const double share : {0.05, 0.3, 0.6}) {
    Random random(7);
    VoxelGrid noise;
    for (int i = 20; i < 40; ++i) {
      for (int j = 20; j < 40; ++j) {
        for (int k = 20; k < 40; ++k) {
          noise.occupied[VoxelGrid::Index(i, j, k)] = random.Uniform() < share ? 1 : 0;
        }
      }
    }
    SurfaceOptions options;
    options.min_component_share = 0;
    const MeshCheck check = CheckMesh(*ExtractSurface(noise, options));
    EXPECT_TRUE(check.ok()) << check.fault << " at " << share;
  }
}

TEST(ExtractSurface, RefusesEmptyAndMisshapenGrids) {
  EXPECT_EQ(ExtractSurface(VoxelGrid(), {}).error().code, ErrorCode::kInvalidInput);
  VoxelGrid short_grid;
  short_grid.occupied.resize(100, 1);
  EXPECT_EQ(ExtractSurface(short_grid, {}).error().code, ErrorCode::kInvalidInput);
}

}  // namespace
}  // namespace deepslam::mesh
