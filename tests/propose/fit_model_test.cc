#include "deepslam/propose/fit_model.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace deepslam::propose {
namespace {

// A box of 40 x 30 x 60 voxels in the middle of the cube.
VoxelGrid Block() {
  VoxelGrid grid;
  for (int i = 12; i < 52; ++i) {
    for (int j = 17; j < 47; ++j) {
      for (int k = 2; k < 62; ++k) grid.occupied[VoxelGrid::Index(i, j, k)] = 1;
    }
  }
  return grid;
}

const Eigen::Vector3d kSize_m(0.4, 0.3, 0.6);

// Its surface, standing at the origin of the level frame.
std::vector<Eigen::Vector3f> SurfacePoints(const CoarseShape& shape) {
  std::vector<Eigen::Vector3f> points;
  const Eigen::Vector3f metres = kSize_m.cast<float>().cwiseQuotient(shape.extent());
  for (const Eigen::Vector3f& p : shape.surface())
    points.emplace_back(p.cwiseProduct(metres) + Eigen::Vector3f(0, 0, 0.3F));
  return points;
}

// What cameras all around measured of a ball in the block's place: something a block agrees with in
// part.
std::vector<ObjectView> BallViews() {
  std::vector<ObjectView> views;
  const PinholeCamera camera{64, 64, 60, 60, 31.5, 31.5};
  for (int n = 0; n < 4; ++n) {
    ObjectView view;
    view.camera = camera;
    view.depth_crop_m = DepthImage(64, 64, 0.0F);
    view.mask_crop = Mask(64, 64);
    for (int v = 0; v < 64; ++v) {
      for (int u = 0; u < 64; ++u) {
        const double away = 0.3 * 0.3 - 1.0;
        const Eigen::Vector3d ray = camera.Ray(u, v);
        const double b = ray.z() / ray.squaredNorm();
        const double under = b * b + away / ray.squaredNorm();
        view.depth_crop_m(u, v) = under > 0 ? static_cast<float>(b - std::sqrt(under)) : 3.0F;
        view.mask_crop(u, v) = under > 0 ? 1 : 0;
      }
    }
    views.push_back(view);
  }
  return views;
}

// The cameras of BallViews(), one metre from the middle of the block, looking at it.
Pose3 CameraFromLevel(int n) {
  const double turn = 0.5 * 3.14159265358979 * n;
  Eigen::Matrix3d level_from_camera;
  const Eigen::Vector3d forward(std::cos(turn), std::sin(turn), 0);
  const Eigen::Vector3d down(0, 0, -1);
  level_from_camera << down.cross(forward), down, forward;
  const Pose3 pose{Eigen::Quaterniond(level_from_camera), Eigen::Vector3d(0, 0, 0.3) - forward};
  return pose.Inverse();
}

TEST(ScorePlacement, IsToldExactlyWhereItBeatsWhatIsToBeBeaten) {
  const CoarseShape shape(Block());
  const std::vector<Eigen::Vector3f> points = SurfacePoints(shape);
  const std::vector<ObjectView> views = BallViews();
  std::vector<shape::DepthView> depth;
  for (int n = 0; n < 4; ++n)
    depth.emplace_back(views[static_cast<std::size_t>(n)], CameraFromLevel(n));
  for (const double yaw : {0.0, 0.3, 0.8}) {
    for (const double side_m : {0.0, 0.05, 0.2}) {
      const Placement placement{kSize_m, {side_m, 0.0}, 0.0, yaw};
      const double score = ScorePlacement(shape, placement, points, depth, 0.03);
      ASSERT_GT(score, 0);
      ASSERT_LT(score, 1);
      EXPECT_EQ(ScorePlacement(shape, placement, points, depth, 0.03, 0.99 * score), score);
      for (const double to_beat : {score, 1.01 * score, 0.9, 1.0}) {
        if (to_beat < score) continue;
        EXPECT_LE(ScorePlacement(shape, placement, points, depth, 0.03, to_beat), to_beat);
      }
    }
  }
}

TEST(RefinePlacement, FindsTheBlockBesideItsPlace) {
  const CoarseShape shape(Block());
  const std::vector<Eigen::Vector3f> points = SurfacePoints(shape);
  const Placement start{kSize_m, {0.04, -0.03}, 0.02, 0.1};
  const Placement found = RefinePlacement(shape, start, kSize_m, points, {});
  EXPECT_LT(found.center_m.norm(), 0.01);
  EXPECT_LT(std::abs(found.bottom_m), 0.01);
  EXPECT_LT(std::abs(found.yaw_rad), 0.03);
}

}  // namespace
}  // namespace deepslam::propose
