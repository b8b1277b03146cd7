// Smoothing of depth on the finest level: noise goes, steps and holes stay, whichever way they run.
#include "deepslam/alignment/image_pyramid.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "alignment/box_world.h"
#include "deepslam/alignment/reference_pixels.h"

namespace deepslam::alignment {
namespace {

constexpr int kSide = 96;
const PinholeCamera kCamera{kSide, kSide, 80, 80, 0.5 * (kSide - 1), 0.5 * (kSide - 1)};
const DepthNoise kNoise;

// Depth by pixel, with noise of `times` what the model says.
DepthImage Measured(const std::function<float(int, int)>& depth_m, double times = 1) {
  std::mt19937 random(7);
  std::normal_distribution<float> normal;
  DepthImage image(kSide, kSide);
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u < kSide; ++u) {
      const float z = depth_m(u, v);
      image(u, v) = z > 0 ? z + static_cast<float>(times) * kNoise.SigmaM(z) * normal(random) : 0;
    }
  }
  return image;
}

UnfilledVector<float> Smoothed(const DepthImage& image, bool smooth = true) {
  PyramidOptions options;
  options.smooth_depth = smooth;
  return BuildPyramid(StoredDepth(image), IntensityImage(), kCamera, options)
      .levels.front()
      .depth_m;
}

// Root mean square of what differs from the truth, in the model's standard deviations, where
// `counts`; infinite where depth is missing.
double Error(const UnfilledVector<float>& depth_m,
             const std::function<float(int, int)>& truth_m,
             const std::function<bool(int, int)>& counts) {
  double sum = 0;
  int count = 0;
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u < kSide; ++u) {
      if (!counts(u, v)) continue;
      const float z = depth_m[static_cast<std::size_t>(v * kSide + u)];
      if (!(z > 0)) return INFINITY;
      sum += std::pow(static_cast<double>((z - truth_m(u, v)) / kNoise.SigmaM(truth_m(u, v))), 2);
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

bool Inside(int u, int v) { return std::min(u, v) >= 2 && std::max(u, v) < kSide - 2; }
bool Everywhere(int, int) { return true; }

TEST(ImagePyramid, NoiseOfASurfaceFallsByAsMuchAsItsWindowHolds) {
  const auto slanted = [](int u, int v) { return 1.5F + 0.001F * static_cast<float>(u - v); };
  for (const double times : {1.0, 3.0}) {
    const DepthImage image = Measured(slanted, times);
    const double before = Error(Smoothed(image, false), slanted, Inside);
    const double after = Error(Smoothed(image), slanted, Inside);
    EXPECT_NEAR(before, times, 0.1 * times);
    // Twenty independent pixels; range weights take part of that.
    EXPECT_LT(after, before / 3) << times;
    EXPECT_LT(Error(Smoothed(image), slanted, Everywhere), before / 2) << "at the image's border";
  }
}

// Sensor's numbers that are turned to metres as they are taken, and those that were before.
TEST(ImagePyramid, IsTheSameOfDepthInEitherForm) {
  const auto slanted = [](int u, int v) {
    return (u / 9 + v / 7) % 5 == 0 ? 0.0F : 1.5F + 0.001F * static_cast<float>(u - v);
  };
  const DepthImage image = Measured(slanted, 2);
  const MetresOfRaw metres(1000.0);
  RawDepthImage raw(kSide, kSide);
  for (std::size_t n = 0; n < raw.size(); ++n)
    raw.data()[n] = static_cast<std::uint16_t>(1000 * image.data()[n]);
  for (const int width : {kSide, kSide / 2, kSide / 3}) {
    PyramidOptions options;
    options.work_width_px = width;
    const FramePyramid of_raw =
        BuildPyramid(StoredDepth(raw, metres), IntensityImage(), kCamera, options);
    const FramePyramid of_metres =
        BuildPyramid(StoredDepth(metres.Of(raw)), IntensityImage(), kCamera, options);
    ASSERT_EQ(of_raw.levels.size(), of_metres.levels.size());
    for (std::size_t k = 0; k < of_raw.levels.size(); ++k)
      EXPECT_EQ(of_raw.levels[k].depth_m, of_metres.levels[k].depth_m) << width << " level " << k;
    EXPECT_EQ(of_raw.noise_scale, of_metres.noise_scale);
    EXPECT_EQ(of_raw.valid_share, of_metres.valid_share);
  }
}

TEST(ImagePyramid, StepsStayWhereTheyAre) {
  const auto across = [](int u, int) { return u < kSide / 2 ? 1.2F : 1.5F; };
  const auto along = [](int, int v) { return v < kSide / 2 ? 1.2F : 1.5F; };
  const auto aslant = [](int u, int v) { return u + v < kSide ? 1.2F : 1.5F; };
  const auto corner = [](int u, int v) { return std::max(u, v) < kSide / 2 ? 1.2F : 1.5F; };
  const std::vector<std::function<float(int, int)>> steps = {across, along, aslant, corner};
  for (const auto& step : steps) {
    const auto at_step = [&](int u, int v) {
      return u > 0 && v > 0 && u + 1 < kSide && v + 1 < kSide &&
             (step(u - 1, v) != step(u + 1, v) || step(u, v - 1) != step(u, v + 1));
    };
    EXPECT_LT(Error(Smoothed(Measured(step)), step, at_step), 0.75);
  }
}

TEST(ImagePyramid, WhatWasNotMeasuredStaysSoAndPullsNothing) {
  const auto wall = [](int, int) { return 2.0F; };
  const auto in_hole = [](int u, int v) { return (u / 6 + v / 6) % 2 == 0 || u % 7 == 0; };
  const auto with_holes = [&](int u, int v) { return in_hole(u, v) ? 0.0F : wall(u, v); };
  const UnfilledVector<float> smoothed = Smoothed(Measured(with_holes));
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u < kSide; ++u) {
      if (in_hole(u, v)) {
        EXPECT_EQ(smoothed[static_cast<std::size_t>(v * kSide + u)], 0) << u << ' ' << v;
      }
    }
  }
  EXPECT_LT(Error(smoothed, wall, [&](int u, int v) { return !in_hole(u, v); }), 0.7);
}

TEST(ImagePyramid, RowsAndColumnsAreAlikeToWithinTheNoiseThatIsLeft) {
  const auto bent = [](int u, int v) {
    return 1.4F + 0.0001F * static_cast<float>(u * u) + (v > 60 ? 0.2F : 0.0F);
  };
  const DepthImage image = Measured(bent);
  DepthImage turned(kSide, kSide);
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u < kSide; ++u) turned(u, v) = image(v, u);
  }
  const UnfilledVector<float> one = Smoothed(image), other = Smoothed(turned);
  UnfilledVector<float> back(one.size());
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u < kSide; ++u)
      back[static_cast<std::size_t>(v * kSide + u)] =
          other[static_cast<std::size_t>(u * kSide + v)];
  }
  const auto by_one = [&](int u, int v) { return one[static_cast<std::size_t>(v * kSide + u)]; };
  EXPECT_LT(Error(back, by_one, Everywhere), Error(one, bent, Everywhere));
}

TEST(BuildPyramid, TakesDepthOutOfRangeAndColourOfAnotherSizeAsMissing) {
  Frame frame = testing_support::RenderFrame(testing_support::BoxWorld::Wall(), Pose3{}, 0.0);
  frame.depth_m(80, 60) = -1.0F;
  frame.depth_m(81, 60) = std::numeric_limits<float>::infinity();
  frame.depth_m(82, 60) = 1e9F;
  frame.colour = ColourImage(7, 5);
  const FramePyramid pyramid = BuildPyramid(frame, testing_support::kSmallCamera, PyramidOptions{});
  const PyramidLevel& level = pyramid.levels.front();
  for (int u = 80; u <= 82; ++u)
    EXPECT_EQ(level.depth_m[static_cast<std::size_t>(60 * 160 + u)], 0.0F);
  EXPECT_TRUE(level.intensity.empty());
  EXPECT_TRUE(AsReference(pyramid).levels.front().gradients.empty());
}

}  // namespace
}  // namespace deepslam::alignment
