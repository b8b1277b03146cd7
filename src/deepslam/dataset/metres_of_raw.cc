#include "deepslam/dataset/metres_of_raw.h"

#include <algorithm>
#include <bit>
#include <cstddef>

#include "deepslam/dataset/stored_frames.h"

namespace deepslam::dataset {

MetresOfRaw::MetresOfRaw(double depth_units_per_m)
    : units_per_m_(static_cast<float>(depth_units_per_m)), metres_(kSaturatedDepth + 1U, 0.0F) {
  for (std::size_t raw = 1; raw < kSaturatedDepth; ++raw) {
    const double depth_m = static_cast<double>(raw) / depth_units_per_m;
    if (depth_m <= kMaxDepthM) metres_[raw] = static_cast<float>(depth_m);
  }
}

DepthImage MetresOfRaw::Of(const RawDepthImage& raw) const {
  DepthImage depth_m(raw.width(), raw.height());
  std::ranges::transform(
      raw, depth_m.begin(), [this](std::uint16_t value) { return metres_[value]; });
  return depth_m;
}

std::optional<RawDepthImage> MetresOfRaw::RawOf(const DepthImage& depth_m) const {
  constexpr auto kMost = static_cast<float>(kSaturatedDepth);
  RawDepthImage raw(depth_m.width(), depth_m.height());
  std::uint32_t differences = 0;
  std::uint16_t* next = raw.data();
  for (const float depth : depth_m) {
    const float scaled = depth * units_per_m_ + 0.5F;
    const float nearest = scaled > 0 ? (scaled < kMost ? scaled : kMost) : 0;  // NaN: 0
    *next = static_cast<std::uint16_t>(nearest);
    differences |=
        std::bit_cast<std::uint32_t>(metres_[*next++]) ^ std::bit_cast<std::uint32_t>(depth);
  }
  if (differences != 0) return std::nullopt;
  return raw;
}

}  // namespace deepslam::dataset
