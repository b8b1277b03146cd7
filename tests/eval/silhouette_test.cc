#include "deepslam/eval/silhouette.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "deepslam/shape/rasterise_depth.h"

namespace deepslam::eval {
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

Mask MaskOf(const DepthImage& depth_m) {
  Mask mask(depth_m.width(), depth_m.height(), 0);
  for (std::size_t i = 0; i < mask.size(); ++i) mask.data()[i] = depth_m.data()[i] > 0 ? 1 : 0;
  return mask;
}

TEST(CompareSilhouette, AModelInItsOwnMaskIsOne) {
  const TriangleMesh board = Board(0.3, 0.2, 2);
  const DepthImage depth_m = shape::RasteriseDepth(board, Pose3(), kCamera);
  const SilhouetteOverlap overlap =
      CompareSilhouette(board, Pose3(), kCamera, MaskOf(depth_m), depth_m);
  EXPECT_EQ(overlap.iou, 1.0);
  EXPECT_EQ(overlap.num_occluded, 0);
  EXPECT_NEAR(overlap.num_model, 0.6 * 0.4 * 150 * 150 / 4, 80);
}

TEST(CompareSilhouette, HalfShiftedModelHasAThird) {
  const TriangleMesh board = Board(0.3, 0.2, 2);
  const DepthImage depth_m = shape::RasteriseDepth(board, Pose3(), kCamera);
  const SilhouetteOverlap overlap =
      CompareSilhouette(Board(0.3, 0.2, 2, 0.3), Pose3(), kCamera, MaskOf(depth_m), depth_m);
  EXPECT_NEAR(overlap.iou, 1.0 / 3.0, 0.02);
}

TEST(CompareSilhouette, WhatNobodyMeasuredCountsUnlessLeftOut) {
  const TriangleMesh board = Board(0.3, 0.2, 2, 0);
  DepthImage depth_m = shape::RasteriseDepth(board, Pose3(), kCamera);
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 80; u < kCamera.width; ++u) depth_m(u, v) = 0;
  }
  const Mask mask = MaskOf(depth_m);
  EXPECT_NEAR(CompareSilhouette(board, Pose3(), kCamera, mask, depth_m).iou, 0.5, 0.03);
  EXPECT_EQ(
      CompareSilhouette(board, Pose3(), kCamera, mask, depth_m, {.leave_out_unmeasured = true}).iou,
      1);
}

TEST(CompareSilhouette, WhatSomethingNearerHidesIsLeftOut) {
  const TriangleMesh board = Board(0.3, 0.2, 2);
  DepthImage depth_m = shape::RasteriseDepth(board, Pose3(), kCamera);
  // The right half is hidden by something at 1 m, and the segment holds the left half only.
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 80; u < kCamera.width; ++u) depth_m(u, v) = 1;
  }
  Mask mask = MaskOf(depth_m);
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 80; u < kCamera.width; ++u) mask(u, v) = 0;
  }
  const SilhouetteOverlap hidden = CompareSilhouette(board, Pose3(), kCamera, mask, depth_m);
  EXPECT_EQ(hidden.iou, 1.0);
  EXPECT_GT(hidden.num_occluded, 0);
  // The same with free space there instead is half an overlap.
  for (float& d : depth_m) d = d == 1 ? 5 : d;
  EXPECT_NEAR(CompareSilhouette(board, Pose3(), kCamera, mask, depth_m).iou, 0.5, 0.03);
}

TEST(CompareSilhouette, NothingAgainstNothingIsZero) {
  const SilhouetteOverlap overlap = CompareSilhouette(
      TriangleMesh(), Pose3(), kCamera, Mask(160, 120, 0), DepthImage(160, 120, 1));
  EXPECT_EQ(overlap.iou, 0.0);
}

}  // namespace
}  // namespace deepslam::eval
