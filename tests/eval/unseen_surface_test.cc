#include "deepslam/eval/unseen_surface.h"

#include <algorithm>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "deepslam/eval/surface_comparison.h"
#include "deepslam/shape/rasterise_depth.h"
#include "deepslam/shape/voxelize.h"
#include "support/box_meshes.h"

namespace deepslam::eval {
namespace {

constexpr int kNumber = 3;
const PinholeCamera kCamera{80, 60, 60, 60, 39.5, 29.5};
// The box of 1 m stands with its front, z = -0.5, 2 m before the camera.
const Pose3 kCameraFromWorld{Eigen::Quaterniond::Identity(), {0, 0, 2.5}};

struct RenderedView {
  DepthImage depth_m;
  Image<std::uint16_t> instances;
};

RenderedView Render(const TriangleMesh& mesh, const Pose3& camera_from_world) {
  RenderedView view{shape::RasteriseDepth(mesh, camera_from_world, kCamera),
                    Image<std::uint16_t>(kCamera.width, kCamera.height, 0)};
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 0; u < kCamera.width; ++u) {
      if (view.depth_m(u, v) > 0) view.instances(u, v) = kNumber;
    }
  }
  return view;
}

class UnseenSurface : public ::testing::Test {
 protected:
  void See(const Pose3& camera_from_world, const RenderedView& view, int number = kNumber) {
    MarkSeen({kCamera, camera_from_world, view.depth_m, view.instances}, number, points_, seen_);
  }

  TriangleMesh mesh_ = testing_support::BoxMesh({1, 1, 1});
  std::vector<Eigen::Vector3d> points_ = SampleSurface(mesh_, {}, 1e-3, 1);
  std::vector<bool> seen_ = std::vector<bool>(points_.size(), false);
};

TEST_F(UnseenSurface, AFrameSeesTheFrontAndNoOtherSide) {
  See(kCameraFromWorld, Render(mesh_, kCameraFromWorld));
  int front = 0;
  for (std::size_t n = 0; n < points_.size(); ++n) {
    if (points_[n].z() > -0.4) {
      EXPECT_FALSE(seen_[n]) << points_[n].transpose();
    }
    const bool is_inner = points_[n].head<2>().cwiseAbs().maxCoeff() < 0.45;
    if (points_[n].z() < -0.499 && is_inner) {
      EXPECT_TRUE(seen_[n]) << points_[n].transpose();
      ++front;
    }
  }
  EXPECT_GT(front, 500);
}

TEST_F(UnseenSurface, FramesAddUpAndNothingIsForgotten) {
  See(kCameraFromWorld, Render(mesh_, kCameraFromWorld));
  const std::vector<bool> first = seen_;
  const Pose3 behind{
      Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitY())),
      {0, 0, 2.5}};
  See(behind, Render(mesh_, behind));
  std::size_t more = 0;
  for (std::size_t n = 0; n < points_.size(); ++n) {
    EXPECT_TRUE(seen_[n] || !first[n]);
    if (seen_[n] && !first[n]) ++more;
  }
  EXPECT_GT(more, 500U);
}

TEST_F(UnseenSurface, WhatHidesAnObjectOrHasNoDepthShowsNothingOfIt) {
  RenderedView view = Render(mesh_, kCameraFromWorld);
  See(kCameraFromWorld, view, kNumber + 1);  // the pixels are of another object
  for (auto& depth_m : view.depth_m) depth_m = 0;
  See(kCameraFromWorld, view);
  for (auto& depth_m : view.depth_m) depth_m = 1.5F;  // something nearer
  See(kCameraFromWorld, view);
  EXPECT_EQ(std::ranges::count(seen_, true), 0);
}

TEST_F(UnseenSurface, AModelInPlaceHasAllPointsAndOneThatIsTooShortLacksItsBack) {
  const shape::ShapeModel model(shape::Voxelize(mesh_).value());
  const Similarity3 in_place{1 / kModelExtent, Eigen::Quaterniond::Identity(), {0, 0, 0}};
  EXPECT_EQ(ShareOnSurface(model, in_place, points_), 1);
  std::vector<Eigen::Vector3d> back;
  for (const Eigen::Vector3d& p : points_) {
    if (p.z() > 0.499) back.push_back(p);
  }
  ASSERT_GT(back.size(), 500U);
  const Similarity3 forward{1 / kModelExtent, Eigen::Quaterniond::Identity(), {0, 0, -0.2}};
  EXPECT_LT(ShareOnSurface(model, forward, back), 0.3);  // its sides reach to the rims alone
  EXPECT_EQ(ShareOnSurface(model, in_place, {}), 0);
  EXPECT_EQ(ShareOnSurface(shape::ShapeModel(VoxelGrid()), in_place, points_), 0);
}

TEST_F(UnseenSurface, PointsBehindTheCameraAndOutsideTheImageAreUnseen) {
  const RenderedView view = Render(mesh_, kCameraFromWorld);
  points_ = {{0, 0, -9}, {40, 0, 0}, {0, -40, 0}, {std::numeric_limits<double>::quiet_NaN(), 0, 0}};
  seen_.assign(points_.size(), false);
  See(kCameraFromWorld, view);
  EXPECT_EQ(std::ranges::count(seen_, true), 0);
}

}  // namespace
}  // namespace deepslam::eval
