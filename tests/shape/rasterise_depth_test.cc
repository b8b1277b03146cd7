#include "deepslam/shape/rasterise_depth.h"

#include <limits>
#include <utility>

#include <gtest/gtest.h>

namespace deepslam::shape {
namespace {

const PinholeCamera kCamera{160, 120, 150, 150, 79.5, 59.5};

// A rectangle facing the camera, half sizes and distance in metres.
TriangleMesh Board(double half_x, double half_y, double z, double x = 0) {
  TriangleMesh mesh;
  for (const auto& [a, b] :
       {std::pair{-half_x, -half_y}, {half_x, -half_y}, {half_x, half_y}, {-half_x, half_y}}) {
    mesh.vertices.push_back(Eigen::Vector3d(x + a, b, z).cast<float>());
  }
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

TEST(RasteriseDepth, AgreesWithRayPlaneIntersection) {
  // The plane 0.3 x + 0.2 y + z = 2 as one large tilted triangle that fills the image.
  const auto on_plane = [](double x, double y) -> Eigen::Vector3f {
    return Eigen::Vector3d(x, y, 2 - 0.3 * x - 0.2 * y).cast<float>();
  };
  TriangleMesh mesh;
  mesh.vertices = {on_plane(-4, -4), on_plane(6, -4), on_plane(-1, 6)};
  mesh.faces = {{0, 1, 2}};
  const DepthImage depth_m = RasteriseDepth(mesh, Pose3(), kCamera);
  for (int v = 0; v < kCamera.height; v += 7) {
    for (int u = 0; u < kCamera.width; u += 7) {
      const Eigen::Vector3d ray = kCamera.Ray(u, v);
      EXPECT_NEAR(depth_m(u, v), 2 / ray.dot(Eigen::Vector3d(0.3, 0.2, 1)), 1e-5) << u << " " << v;
    }
  }
}

TEST(RasteriseDepth, CutsFacesThatReachBehindTheCamera) {
  // A floor 1 m below, from 5 m behind the camera to 50 m ahead.
  TriangleMesh floor;
  floor.vertices = {{-50, 1, -5}, {50, 1, -5}, {50, 1, 50}, {-50, 1, 50}};
  floor.faces = {{0, 1, 2}, {0, 2, 3}};
  const DepthImage depth_m = RasteriseDepth(floor, Pose3(), kCamera);
  for (int v = 64; v < kCamera.height; ++v)
    EXPECT_NEAR(depth_m(80, v), kCamera.fy / (v - kCamera.cy), 1e-3);
  for (int v = 0; v < 59; ++v) EXPECT_EQ(depth_m(80, v), 0);
}

TEST(RasteriseDepth, NearestFaceWinsWhateverTheOrder) {
  TriangleMesh both = Board(1, 1, 3);
  const TriangleMesh front = Board(0.2, 0.2, 1);
  for (const Eigen::Vector3f& vertex : front.vertices) both.vertices.push_back(vertex);
  TriangleMesh turned = both;
  both.faces = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
  turned.faces = {{6, 5, 4}, {7, 6, 4}, {2, 1, 0}, {3, 2, 0}};
  const DepthImage depth_m = RasteriseDepth(both, Pose3(), kCamera);
  EXPECT_NEAR(depth_m(80, 60), 1, 1e-6);
  EXPECT_NEAR(depth_m(40, 60), 3, 1e-6);
  EXPECT_EQ(RasteriseDepth(turned, Pose3(), kCamera), depth_m);
}

TEST(RasteriseDepth, BrokenMeshesDrawNothing) {
  TriangleMesh mesh = Board(1, 1, 2);
  mesh.vertices[0].x() = std::numeric_limits<float>::quiet_NaN();
  mesh.vertices[3].x() = std::numeric_limits<float>::infinity();
  mesh.faces.push_back({0, 1, 99});
  for (const float d : RasteriseDepth(mesh, Pose3(), kCamera)) EXPECT_EQ(d, 0);
}

}  // namespace
}  // namespace deepslam::shape
