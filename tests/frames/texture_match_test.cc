#include "deepslam/frames/texture_match.h"

#include <cmath>
#include <cstddef>

#include <gtest/gtest.h>

namespace deepslam {
namespace {

constexpr PinholeCamera kCamera{80, 60, 65, 65, 39.5, 29.5};
constexpr float kWall_m = 2;

// Grain of a wall that the camera has moved along by so many pixels.
Image<float> Grained(double shift_px) {
  Image<float> image(kCamera.width, kCamera.height);
  for (int v = 0; v < image.height(); ++v) {
    for (int u = 0; u < image.width(); ++u) {
      const double x = u + shift_px;
      image(u, v) = static_cast<float>(120 + std::sin(1.3 * x + 0.4 * v) + std::sin(0.7 * x - v));
    }
  }
  return image;
}

UnfilledVector<float> Depth(float depth_m) {
  return UnfilledVector<float>(static_cast<std::size_t>(kCamera.width * kCamera.height), depth_m);
}

Pose3 Sideways(double px) {
  return {Eigen::Quaterniond::Identity(), {px * static_cast<double>(kWall_m) / kCamera.fx, 0, 0}};
}

TEST(TextureMatch, IsAlikeAtTheRightPlaceAlone) {
  const Image<float> i = Grained(0), j = Grained(6);
  const TextureMatch match({kCamera, i}, {kCamera, j}, Depth(kWall_m), 2);
  EXPECT_GT(match.Compare(Sideways(6)).correlation, 0.95);
  EXPECT_GT(match.ShareOfPatches(Sideways(6)), 0.9);
  EXPECT_LT(match.Compare(Pose3()).correlation, 0.5);
  EXPECT_NEAR(match.DistancePx(Sideways(6), Pose3()), 6, 1e-6);
  EXPECT_NEAR(match.mean_depth_m(), 2, 1e-6);
}

TEST(TextureMatch, SaysNothingWhereLittleIsSeenByBoth) {
  const Image<float> image = Grained(0);
  const TextureMatch match({kCamera, image}, {kCamera, image}, Depth(kWall_m), 2);
  const Pose3 behind{Eigen::Quaterniond::Identity(), {0, 0, -3}};
  for (const Pose3& far : {Sideways(70), behind}) EXPECT_EQ(match.Compare(far).num_points, 0);
  const TextureMatch without({kCamera, image}, {kCamera, image}, Depth(0), 2);
  EXPECT_EQ(without.Compare(Pose3()).num_points, 0);
  EXPECT_EQ(without.ShareOfPatches(Pose3()), 0);
  EXPECT_EQ(without.DistancePx(Pose3(), Sideways(1)), 0);
}

}  // namespace
}  // namespace deepslam
