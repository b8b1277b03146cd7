#include "deepslam/stages/compact_shape.h"

#include <cmath>

#include <gtest/gtest.h>

#include "deepslam/gltf/draco_mesh.h"
#include "deepslam/mesh/check_mesh.h"
#include "deepslam/mesh/surface_distance.h"
#include "deepslam/stages/object_mesh.h"
#include "support/voxel_shapes.h"

namespace deepslam::stages {
namespace {

using namespace testing_support;  // NOLINT(google-build-using-namespace)

// A sofa as a fusion of noisy depth has it.
VoxelGrid BumpySofa() {
  return FillGrid([](double x, double y, double z) {
    const double bump = 1.2 * std::sin(0.5 * x) * std::cos(0.6 * y) * std::sin(0.5 * z);
    return std::abs(x) < 16 + bump && std::abs(y) < 30 + bump && std::abs(z) < 16 + bump &&
           !(x > 0 && z > 2 && std::abs(y) < 24);
  });
}

TEST(EncodeCompactShape, IsSmallAndClosedAndWithinItsStatedError) {
  constexpr double kScaleM = 1.7;
  for (const VoxelGrid& grid : {BumpySofa(), ChairWithThinLegs(), Box(30, 12, 18)}) {
    TriangleMesh mesh = *MakeObjectMesh(grid, kScaleM, {}, {});
    mesh.colours.assign(mesh.vertices.size(), Rgb8{1, 2, 3});
    const Result<std::string> bytes = EncodeCompactShape(mesh, kScaleM);
    ASSERT_TRUE(bytes.ok()) << bytes.error().message;
    const Result<TriangleMesh> decoded = gltf::DracoDecode(*bytes);
    ASSERT_TRUE(decoded.ok());
    const mesh::MeshCheck check = mesh::CheckMesh(*decoded);
    EXPECT_TRUE(check.ok()) << check.fault;
    EXPECT_FALSE(mesh::SelfIntersects(*decoded));
    EXPECT_TRUE(decoded->colours.empty());
    EXPECT_LE(mesh::SurfaceDistance(mesh, *decoded), kEmbeddedErrorVoxels * kVoxelSize * kScaleM);
    mesh.colours.clear();
    EXPECT_LT(bytes->size(), gltf::DracoEncode(mesh, 14)->size() / 2);
  }
}

TEST(EncodeCompactShape, GivesTheSameBytesTwiceAndRefusesWhatIsOpen) {
  TriangleMesh mesh = *MakeObjectMesh(Box(20, 12, 8), 1.0, {}, {});
  EXPECT_EQ(*EncodeCompactShape(mesh, 1.0), *EncodeCompactShape(mesh, 1.0));
  mesh.faces.pop_back();
  EXPECT_FALSE(EncodeCompactShape(mesh, 1.0).ok());
  EXPECT_FALSE(EncodeCompactShape(TriangleMesh(), 1.0).ok());
}

}  // namespace
}  // namespace deepslam::stages
