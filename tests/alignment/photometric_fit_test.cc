#include "deepslam/alignment/photometric_fit.h"

#include <cstddef>

#include <gtest/gtest.h>

#include "deepslam/core/random.h"

namespace deepslam::alignment {
namespace {

struct Truth {
  double gain = 1, bias = 0, falloff = 0;
};

// Pairs of intensities less kMiddleGrey, as PhotometricFit takes them, seen at angles whose squared
// tangents differ by up to `most_rho2`; noise is one standard deviation, grey levels.
PhotometricFit FitTo(const Truth& truth, double most_rho2, double noise = 0, double contrast = 60) {
  Random random(1, "intensity", 0);
  Column source{}, reference{}, darker{}, weight{};
  PhotometricFit fit;
  for (int batch = 0; batch < 8; ++batch) {
    for (std::size_t k = 0; k < kBatch; ++k) {
      const double of_j = random.Uniform(120 - contrast, 120 + contrast);
      const double seen_darker = of_j * random.Uniform(-most_rho2, most_rho2);
      const double of_i =
          truth.gain * of_j + truth.bias + truth.falloff * seen_darker + noise * random.Normal();
      source[k] = static_cast<float>(of_j) - kMiddleGrey;
      reference[k] = static_cast<float>(of_i) - kMiddleGrey;
      darker[k] = static_cast<float>(seen_darker);
      weight[k] = 1;
    }
    fit.Add(source, reference, weight, kBatch);
    fit.AddFalloff(source, reference, darker, weight, kBatch);
  }
  return fit;
}

TEST(PhotometricFit, FindsExposureAndFalloff) {
  for (const Truth& truth : {Truth{}, Truth{0.8, 12, 0}, Truth{1.2, -9, -0.3}, Truth{1, 0, 0.2}}) {
    float gain = 1, bias = 0, falloff = 0;
    FitTo(truth, 0.2, 3).Solve(gain, bias, falloff);
    EXPECT_NEAR(gain, truth.gain, 0.01);
    EXPECT_NEAR(bias, truth.bias, 1.5);
    EXPECT_NEAR(falloff, truth.falloff, 0.02);
  }
}

TEST(PhotometricFit, FalloffStaysAtNothingWhereTheFramesSeeAlike) {
  float gain = 1, bias = 0, falloff = 0;
  FitTo({0.9, 5, -0.3}, 1e-4, 5).Solve(gain, bias, falloff);
  EXPECT_NEAR(falloff, 0, 0.05);
  EXPECT_NEAR(gain, 0.9, 0.02);
}

TEST(PhotometricFit, KeepsWhatItHasWhereAllIsOfOneIntensity) {
  float gain = 0.7F, bias = 3, falloff = -0.1F;
  FitTo({1, 0, 0}, 0.2, 0, 1).Solve(gain, bias, falloff);
  PhotometricFit{}.Solve(gain, bias, falloff);
  EXPECT_EQ(gain, 0.7F);
  EXPECT_EQ(bias, 3);
  EXPECT_EQ(falloff, -0.1F);
}

}  // namespace
}  // namespace deepslam::alignment
