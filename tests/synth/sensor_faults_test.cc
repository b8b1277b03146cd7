#include "deepslam/synth/sensor_faults.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace deepslam::synth {
namespace {

const PinholeCamera kCamera{320, 240, 262.5, 262.5, 159.5, 119.5};
const SensorFaults kNoiseOnly{true, false, false};
const SensorFaults kHolesOnly{false, true, false};

// A wall across the view; `step_m` nearer right of column `edge`.
render::RenderedView Wall(double depth_m, double step_m = 0, int edge = 1 << 20) {
  render::RenderedView view{DepthImage(kCamera.width, kCamera.height),
                            Image<render::RayHit>(kCamera.width, kCamera.height)};
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 0; u < kCamera.width; ++u) {
      view.depth_m(u, v) = static_cast<float>(u < edge ? depth_m : depth_m - step_m);
      view.hits(u, v).instance = 0;
      view.hits(u, v).normal_world = -Eigen::Vector3f::UnitZ();
    }
  }
  return view;
}

TEST(DepthFaults, NoiseHasTheModelsSizeAndNoBias) {
  for (const double depth_m : {1.0, 2.0, 3.5}) {
    // A step of disparity is even noise of its width, over depths that lie anywhere between two
    // steps.
    const double step_m = depth_m * depth_m * kDisparityStepPx / (kCamera.fx * kBaselineM);
    constexpr int kNumDepths = 8;
    double sum = 0, sum_squares = 0, count = 0;
    for (int k = 0; k < kNumDepths; ++k) {
      const double wall_m = depth_m + (static_cast<double>(k) / kNumDepths - 0.5) * step_m;
      for (const float d : ApplyDepthFaults(Wall(wall_m), kCamera, Pose3(), kNoiseOnly, 1, 1)) {
        sum += d - wall_m;
        sum_squares += (d - wall_m) * (d - wall_m);
        ++count;
      }
    }
    const double expected_m = std::hypot(AxialNoise(depth_m), step_m / std::sqrt(12.0));
    EXPECT_NEAR(std::sqrt(sum_squares / count), expected_m, 0.1 * expected_m) << depth_m << " m";
    EXPECT_LT(std::abs(sum / count), 0.1 * step_m) << depth_m << " m";
  }
}

TEST(DepthFaults, DepthComesInStepsOfDisparity) {
  for (const float d : ApplyDepthFaults(Wall(2.3), kCamera, Pose3(), kNoiseOnly, 1, 1)) {
    const double steps = kCamera.fx * kBaselineM / d / kDisparityStepPx;
    ASSERT_NEAR(steps, std::round(steps), 1e-4);
  }
}

TEST(DepthFaults, SwitchedOffTheyChangeNothing) {
  const render::RenderedView wall = Wall(2.0, 0.8, 160);
  EXPECT_EQ(ApplyDepthFaults(wall, kCamera, Pose3(), {false, false, false}, 1, 1), wall.depth_m);
}

TEST(DepthFaults, ProjectorShadowIsAsWideAsTheBaselineSays) {
  const double far_m = 3.0, near_m = 1.5;
  const int edge = 160;
  const DepthImage seen =
      ApplyDepthFaults(Wall(far_m, far_m - near_m, edge), kCamera, Pose3(), kHolesOnly, 1, 1);
  int num_holes = 0;
  for (int u = 0; u < kCamera.width; ++u) num_holes += seen(u, 100) == 0 ? 1 : 0;
  // Either this side or the other is in shadow, by the difference of disparities.
  const double width_px = kCamera.fx * kBaselineM * (1 / near_m - 1 / far_m);
  const DepthImage other =
      ApplyDepthFaults(Wall(near_m, near_m - far_m, edge), kCamera, Pose3(), kHolesOnly, 1, 1);
  int num_other = 0;
  for (int u = 0; u < kCamera.width; ++u) num_other += other(u, 100) == 0 ? 1 : 0;
  EXPECT_NEAR(num_holes + num_other, width_px, 1.5);
  EXPECT_TRUE(num_holes == 0 || num_other == 0);
}

TEST(DepthFaults, GrazingFacesAndFarOnesAreHoles) {
  render::RenderedView wall = Wall(2.0);
  for (render::RayHit& hit : wall.hits)
    hit.normal_world = Eigen::Vector3f(1, 0, -0.001f).normalized();
  const DepthImage grazing = ApplyDepthFaults(wall, kCamera, Pose3(), kHolesOnly, 1, 1);
  for (int v = 0; v < kCamera.height; ++v) EXPECT_EQ(grazing(160, v), 0);
  for (const float d : ApplyDepthFaults(Wall(kMaxRangeM + 0.1), kCamera, Pose3(), kHolesOnly, 1, 1))
    EXPECT_EQ(d, 0);
  for (const float d : ApplyDepthFaults(Wall(2.0), kCamera, Pose3(), kHolesOnly, 1, 1))
    EXPECT_GT(d, 0);
}

TEST(DevelopColour, KeepsCleanGreysAndAddsLittleNoise) {
  const Image<Eigen::Vector3f> grey(64, 48, Eigen::Vector3f::Constant(0.2140f));
  const ColourImage clean = DevelopColour(grey, {false, false, false}, 1, 1);
  EXPECT_EQ(clean(10, 10), (Rgb8{127, 127, 127}));
  const ColourImage noisy = DevelopColour(grey, {false, false, true}, 1, 1);
  double sum = 0, sum_squares = 0;
  for (int v = 20; v < 28; ++v) {
    for (int u = 24; u < 40; ++u) {
      sum += noisy(u, v).g;
      sum_squares += noisy(u, v).g * noisy(u, v).g;
    }
  }
  const double mean = sum / 128;
  const double deviation = std::sqrt(sum_squares / 128 - mean * mean);
  EXPECT_NEAR(mean, 127, 4);
  EXPECT_GT(deviation, 0.3);
  EXPECT_LT(deviation, 6);
  EXPECT_LT(noisy(0, 0).g, noisy(32, 24).g + 5);
}

}  // namespace
}  // namespace deepslam::synth
