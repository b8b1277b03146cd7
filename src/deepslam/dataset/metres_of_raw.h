// What the whole numbers of a capture's depth images stand for.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/dataset/image_files.h"

namespace deepslam::dataset {

// Metres by raw value; 0 for what is no depth: 0, 65535 (saturated) and beyond kMaxDepthM
// (stored_frames.h).
class MetresOfRaw {
 public:
  // Raw value of one metre.
  explicit MetresOfRaw(double depth_units_per_m);

  [[nodiscard]] float operator[](std::uint16_t raw) const { return metres_[raw]; }
  [[nodiscard]] DepthImage Of(const RawDepthImage& raw) const;
  // Nothing where some depth is not what any raw value stands for, to the bit.
  [[nodiscard]] std::optional<RawDepthImage> RawOf(const DepthImage& depth_m) const;

 private:
  float units_per_m_;
  std::vector<float> metres_;
};

}  // namespace deepslam::dataset
