#include "deepslam/mesh/refine_mesh.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "deepslam/mesh/check_mesh.h"
#include "deepslam/mesh/extract_surface.h"
#include "deepslam/mesh/surface_distance.h"
#include "support/voxel_shapes.h"

namespace deepslam::mesh {
namespace {

using namespace testing_support;  // NOLINT(google-build-using-namespace)

TEST(RefineMesh, StaysClosedWithinHalfAVoxelAndGetsSmall) {
  for (const VoxelGrid& grid : {Sphere(12), ChairWithThinLegs(), Box(12, 9, 5)}) {
    const TriangleMesh surface = *ExtractSurface(grid, {});
    RefineOptions options;
    options.max_edge = 10;
    const Result<TriangleMesh> refined = RefineMesh(surface, options);
    ASSERT_TRUE(refined.ok());
    const MeshCheck before = CheckMesh(surface);
    const MeshCheck after = CheckMesh(*refined);
    EXPECT_TRUE(after.ok()) << after.fault;
    EXPECT_EQ(after.num_components, before.num_components);
    EXPECT_FALSE(SelfIntersects(*refined));
    EXPECT_LE(SurfaceDistance(surface, *refined), 0.5 * kVoxelSize);
    EXPECT_LE(refined->faces.size(), 2500U);
    EXPECT_NEAR(after.volume_m3 / before.volume_m3, 1.0, 0.05);
  }
}

TEST(RefineMesh, LeavesVerticesForColoursOnFlatSides) {
  const auto longest = [](const TriangleMesh& mesh) {
    float length = 0;
    for (const auto& face : mesh.faces) {
      for (std::size_t n = 0; n < 3; ++n) {
        length = std::max(length, (mesh.vertices[face[n]] - mesh.vertices[face[(n + 1) % 3]]).norm());
      }
    }
    return static_cast<double>(length);
  };
  const TriangleMesh surface = *ExtractSurface(Box(20, 12, 8), {});
  RefineOptions options;
  options.target_faces = 4;
  EXPECT_LE(longest(*RefineMesh(surface, options)), options.max_edge + 1e-6);
  options.max_edge = 10;
  EXPECT_GT(longest(*RefineMesh(surface, options)), 10 * kVoxelSize);
}

TEST(RefineMesh, KeepsATightBoundInsteadOfTheFaceCount) {
  const TriangleMesh surface = *ExtractSurface(Sphere(12), {});
  RefineOptions options;
  options.max_error = 0.02 * kVoxelSize;
  options.target_faces = 4;
  const Result<TriangleMesh> refined = RefineMesh(surface, options);
  ASSERT_TRUE(refined.ok());
  EXPECT_GT(refined->faces.size(), 400U);
  EXPECT_LE(SurfaceDistance(surface, *refined), options.max_error);
}

TEST(RefineMesh, GivesTheSameMeshTwice) {
  const TriangleMesh surface = *ExtractSurface(ChairWithThinLegs(), {});
  const Result<TriangleMesh> a = RefineMesh(surface, {});
  const Result<TriangleMesh> b = RefineMesh(surface, {});
  EXPECT_EQ(a->vertices, b->vertices);
  EXPECT_EQ(a->faces, b->faces);
}

TEST(RefineMesh, RefusesWhatIsNotClosed) {
  TriangleMesh open = *ExtractSurface(Sphere(8), {});
  open.faces.pop_back();
  EXPECT_FALSE(RefineMesh(open, {}).ok());
  EXPECT_FALSE(RefineMesh(TriangleMesh(), {}).ok());
}

}  // namespace
}  // namespace deepslam::mesh
