#include "deepslam/mesh/object_mesh.h"

#include <atomic>
#include <cmath>

#include <gtest/gtest.h>

#include "deepslam/mesh/check_mesh.h"
#include "support/voxel_shapes.h"

namespace deepslam::mesh {
namespace {

const auto kNeverStop = [] { return false; };

TEST(MakeObjectMesh, IsClosedAndAsLargeAsTheScaleSays) {
  const VoxelGrid grid = testing_support::Box(30, 15, 10);
  for (const double scale_m : {0.5, 2.0}) {
    const Result<TriangleMesh> mesh = MakeObjectMesh(grid, scale_m, {});
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    const MeshCheck check = CheckMesh(*mesh);
    EXPECT_TRUE(check.ok()) << check.fault;
    const double volume_m3 = 60.0 * 30 * 20 * std::pow(kVoxelSize * scale_m, 3);
    EXPECT_NEAR(check.volume_m3, volume_m3, 0.03 * volume_m3);
  }
}

TEST(MakeObjectMeshes, GiveEachObjectItsOwnInTheirOrder) {
  const std::vector<VoxelGrid> grids = {
      testing_support::Box(8, 8, 8), VoxelGrid(), testing_support::RoundTable()};
  const std::vector<double> scales_m = {1, 1, 0.7};
  const std::vector<Result<TriangleMesh>> meshes =
      MakeObjectMeshes(grids, scales_m, {}, kNeverStop);
  ASSERT_EQ(meshes.size(), 3U);
  for (const std::size_t n : {0, 2}) {
    ASSERT_TRUE(meshes[n].ok());
    EXPECT_EQ(meshes[n]->vertices, MakeObjectMesh(grids[n], scales_m[n], {})->vertices);
  }
  EXPECT_FALSE(meshes[1].ok());  // an empty grid has no surface, and the others are none the worse
  EXPECT_TRUE(MakeObjectMeshes({}, {}, {}, kNeverStop).empty());
}

TEST(MakeObjectMeshes, BeginNoneAfterBeingAskedToStop) {
  const std::vector<VoxelGrid> grids(2, testing_support::Box(8, 8, 8));
  const std::vector<double> scales_m = {1, 1};
  for (const auto& mesh : MakeObjectMeshes(grids, scales_m, {}, [] { return true; }))
    EXPECT_EQ(mesh.error().code, ErrorCode::kInterrupted);
}

}  // namespace
}  // namespace deepslam::mesh
