// A frame's depth in the form in which it was read: the sensor's numbers where nothing was
// resampled, or metres. Whoever goes over it once takes rows of it, and needs no image of metres.
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/frames/raw_depth.h"

namespace deepslam {

class StoredDepth {
 public:
  StoredDepth() = default;
  explicit StoredDepth(DepthImage depth_m) : depth_m_(std::move(depth_m)) {}
  StoredDepth(RawDepthImage raw, const MetresOfRaw& metres)
      : raw_(std::move(raw)), metres_(metres) {}

  [[nodiscard]] int width() const { return metres_ ? raw_.width() : depth_m_.width(); }
  [[nodiscard]] int height() const { return metres_ ? raw_.height() : depth_m_.height(); }
  [[nodiscard]] bool empty() const { return metres_ ? raw_.empty() : depth_m_.empty(); }

  [[nodiscard]] float operator()(int u, int v) const {
    return metres_ ? (*metres_)[raw_(u, v)] : depth_m_(u, v);
  }
  // Metres of `count` rows from `v` on, one behind the other: its own, or made in `room`.
  [[nodiscard]] const float* Rows(int v, int count, std::vector<float>& room) const {
    if (!metres_) return depth_m_.row(v);
    const std::size_t size = static_cast<std::size_t>(count) * static_cast<std::size_t>(width());
    room.resize(size);
    metres_->Write({raw_.row(v), size}, room.data());
    return room.data();
  }
  [[nodiscard]] DepthImage TakeMetres() && {
    return metres_ ? metres_->Of(raw_) : std::move(depth_m_);
  }

 private:
  DepthImage depth_m_;  // unless there are raw_ and metres_
  RawDepthImage raw_;
  std::optional<MetresOfRaw> metres_;
};

}  // namespace deepslam
