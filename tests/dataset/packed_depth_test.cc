#include "deepslam/dataset/packed_depth.h"

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "deepslam/frames/raw_depth.h"

namespace deepslam::dataset {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;

// A wall seen askew, with holes and noise, as sensors give it.
RawDepthImage WallRaw(double units_per_m) {
  std::mt19937 random(1);
  RawDepthImage raw(kWidth, kHeight);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const double depth_m =
          1.0 + 0.004 * u + 0.001 * v + 0.001 * static_cast<double>(random() % 5);
      const bool is_hole = (u / 20 + v / 20) % 7 == 0;
      raw(u, v) = is_hole ? kNoDepth : static_cast<std::uint16_t>(depth_m * units_per_m);
    }
  }
  return raw;
}

void ExpectSameBits(const DepthImage& depth_m, const DepthImage& expected_m) {
  ASSERT_EQ(depth_m.width(), expected_m.width());
  ASSERT_EQ(depth_m.height(), expected_m.height());
  for (std::size_t n = 0; n < depth_m.size(); ++n) {
    ASSERT_EQ(std::bit_cast<std::uint32_t>(depth_m.data()[n]),
              std::bit_cast<std::uint32_t>(expected_m.data()[n]))
        << "pixel " << n;
  }
}

std::size_t BytesOfPixels(const DepthImage& depth_m) { return depth_m.size() * sizeof(float); }

TEST(PackedDepth, OfASensorTakesASmallPartOfItsPixels) {
  for (const double units_per_m : {1000.0, 5000.0}) {
    const MetresOfRaw metres(units_per_m);
    const DepthImage depth_m = metres.Of(WallRaw(units_per_m));
    const PackedDepth packed(depth_m, metres);
    ExpectSameBits(packed.Unpacked(), depth_m);
    EXPECT_LT(packed.num_bytes(), BytesOfPixels(depth_m) / 3);
  }
}

// Depth that was registered to colour is no raw value any more.
TEST(PackedDepth, OfNoSensorIsTheSameAgain) {
  const MetresOfRaw metres(1000.0);
  DepthImage depth_m = metres.Of(WallRaw(1000.0));
  DepthImage registered_m = depth_m;
  for (float& depth : registered_m) depth *= 1.0123F;
  ExpectSameBits(PackedDepth(registered_m, metres).Unpacked(), registered_m);
  EXPECT_LT(PackedDepth(registered_m, metres).num_bytes(), BytesOfPixels(registered_m));
  depth_m(17, 3) = std::nextafter(depth_m(17, 3), 0.0F);
  ExpectSameBits(PackedDepth(depth_m, metres).Unpacked(), depth_m);
}

TEST(PackedDepth, WhateverAnImageHoldsComesBack) {
  const MetresOfRaw metres(1000.0);
  using Limits = std::numeric_limits<float>;
  for (const float value : {-0.0F,
                            -1.0F,
                            100.0F,
                            Limits::denorm_min(),
                            Limits::max(),
                            Limits::infinity(),
                            Limits::quiet_NaN()}) {
    const DepthImage depth_m(5, 3, value);
    ExpectSameBits(PackedDepth(depth_m, metres).Unpacked(), depth_m);
  }
  for (const auto& [width, height] : {std::pair(1, 1), {1, 40}, {33, 7}, {0, 0}}) {
    const DepthImage depth_m(width, height, 1.5F);
    ExpectSameBits(PackedDepth(depth_m, metres).Unpacked(), depth_m);
  }
}

// What cannot be packed takes no more than its pixels and a few bytes.
TEST(PackedDepth, NoiseIsNoLarger) {
  const MetresOfRaw metres(1000.0);
  std::mt19937 random(2);
  DepthImage depth_m(kWidth, kHeight);
  for (float& depth : depth_m) depth = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
  const PackedDepth packed(depth_m, metres);
  ExpectSameBits(packed.Unpacked(), depth_m);
  EXPECT_LT(packed.num_bytes(), BytesOfPixels(depth_m) + 64);
}

}  // namespace
}  // namespace deepslam::dataset
