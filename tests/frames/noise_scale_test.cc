#include "deepslam/frames/noise_scale.h"

#include <vector>

#include <gtest/gtest.h>

#include "deepslam/core/random.h"

namespace deepslam {
namespace {

constexpr int kWidth = 160;
constexpr int kHeight = 120;

// A slanted plane with so many times the model's noise, the same for squares of `shared` pixels.
std::vector<float> NoisyPlane(double times, int shared) {
  Random random(7, "noisy plane", 0);
  std::vector<double> normal(kWidth * kHeight);
  for (double& value : normal) value = random.Normal();
  std::vector<float> depth_m;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const double z = 1.0 / (0.5 - 0.001 * u + 0.0005 * v);
      const auto of_square = static_cast<std::size_t>(v / shared * kWidth + u / shared);
      depth_m.push_back(static_cast<float>(z + times * DepthNoise{}.SigmaM(z) * normal[of_square]));
    }
  }
  return depth_m;
}

TEST(NoiseScale, IsThatOfTheNoise) {
  for (const double times : {1.0, 2.0, 4.0}) {
    EXPECT_NEAR(NoiseScaleOf(NoisyPlane(times, 1), kWidth, 1, DepthNoise{}), times, 0.1 * times);
  }
}

TEST(NoiseScale, SeesWhatNeighboursShareAtALargerLagAlone) {
  const std::vector<float> depth_m = NoisyPlane(3, 4);
  EXPECT_LT(NoiseScaleOf(depth_m, kWidth, 1, DepthNoise{}), 1.5);
  EXPECT_NEAR(NoiseScaleOf(depth_m, kWidth, 5, DepthNoise{}), 3, 0.4);
}

TEST(NoiseScale, OfNothingOrNoNoiseIsOne) {
  EXPECT_EQ(NoiseScaleOf(NoisyPlane(0, 1), kWidth, 5, DepthNoise{}), 1);
  EXPECT_EQ(NoiseScaleOf(std::vector<float>(kWidth * kHeight, 0.0F), kWidth, 5, DepthNoise{}), 1);
  EXPECT_EQ(NoiseScaleOf({}, kWidth, 5, DepthNoise{}), 1);
  EXPECT_EQ(NoiseScaleOf({}, 0, 5, DepthNoise{}), 1);
}

TEST(DepthNoise, ReachesAsFarAsItIsThatGood) {
  EXPECT_NEAR(DepthNoise{}.ReachM(DepthSigmaM(4.6)), 4.6, 1e-9);
  EXPECT_LT(DepthNoise{}.Scaled(2).ReachM(0.035), DepthNoise{}.ReachM(0.035));
  EXPECT_EQ(DepthNoise{}.ReachM(0), 0.4);
}

}  // namespace
}  // namespace deepslam
