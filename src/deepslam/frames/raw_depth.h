// Depth as sensors give it: whole numbers, and the metres they stand for.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "deepslam/core/image.h"

namespace deepslam {

using RawDepthImage = Image<std::uint16_t>;

// Depth beyond this is invalid: no sensor this program is made for measures it.
inline constexpr double kMaxDepthM = 20.0;
// Raw depth that means "nothing was measured": zero, and a saturated value.
inline constexpr std::uint16_t kNoDepth = 0;
inline constexpr std::uint16_t kSaturatedDepth = 65535;  // the greatest number of 16 bits

// raw / units_per_m in single precision; 0 for what is no depth: the two above and all beyond
// kMaxDepthM.
class MetresOfRaw {
 public:
  // Raw value of one metre, > 0.
  explicit MetresOfRaw(double units_per_m);

  [[nodiscard]] float operator[](std::uint16_t raw) const {
    const float depth_m = static_cast<float>(raw) / units_per_m_;
    return depth_m <= last_m_ ? depth_m : 0.0F;
  }
  // As many metres as there are raw values.
  void Write(std::span<const std::uint16_t> raw, float* metres) const {
    const MetresOfRaw of = *this;  // that nothing written can change
    for (std::size_t n = 0; n < raw.size(); ++n) metres[n] = of[raw[n]];
  }
  [[nodiscard]] DepthImage Of(const RawDepthImage& raw) const;
  // Nothing where some depth is not what any raw value stands for, to the bit.
  [[nodiscard]] std::optional<RawDepthImage> RawOf(const DepthImage& depth_m) const;

 private:
  float units_per_m_;
  float last_m_;  // of the largest raw value that is depth
};

}  // namespace deepslam
