#include "deepslam/frames/raw_depth.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "deepslam/core/check.h"
#include "deepslam/core/wide_vectors.h"

namespace deepslam {
namespace {

// The largest that is depth.
double LastRaw(double units_per_m) {
  DEEPSLAM_CHECK(units_per_m > 0, "a metre has some units");
  return std::min(std::floor(kMaxDepthM * units_per_m), kSaturatedDepth - 1.0);
}

DEEPSLAM_WIDE_VECTORS void WriteMetres(const MetresOfRaw& metres,
                                       const RawDepthImage& raw,
                                       float* depth_m) {
  metres.Write({raw.data(), raw.size()}, depth_m);
}

}  // namespace

MetresOfRaw::MetresOfRaw(double units_per_m)
    : units_per_m_(static_cast<float>(units_per_m)),
      last_m_(static_cast<float>(LastRaw(units_per_m)) / units_per_m_) {}

DepthImage MetresOfRaw::Of(const RawDepthImage& raw) const {
  DepthImage depth_m(raw.width(), raw.height());
  WriteMetres(*this, raw, depth_m.data());
  return depth_m;
}

std::optional<RawDepthImage> MetresOfRaw::RawOf(const DepthImage& depth_m) const {
  constexpr auto kMostRaw = static_cast<float>(kSaturatedDepth);
  RawDepthImage raw(depth_m.width(), depth_m.height());
  std::uint32_t differences = 0;
  std::uint16_t* next = raw.data();
  for (const float depth : depth_m) {
    const float scaled = depth * units_per_m_ + 0.5F;
    const float nearest = scaled > 0 ? (scaled < kMostRaw ? scaled : kMostRaw) : 0;  // NaN: 0
    *next = static_cast<std::uint16_t>(nearest);
    differences |=
        std::bit_cast<std::uint32_t>((*this)[*next++]) ^ std::bit_cast<std::uint32_t>(depth);
  }
  if (differences != 0) return std::nullopt;
  return raw;
}

}  // namespace deepslam
