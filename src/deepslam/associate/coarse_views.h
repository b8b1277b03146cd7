// What the frames of a capture could see, coarsely and in bounded memory.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "deepslam/core/ids.h"
#include "deepslam/core/image.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::associate {

inline constexpr int kCoarseStep = 8;  // px: depth in so few takes a 64th of the memory

struct CoarseView {
  FrameIdx frame;
  Pose3 camera_from_world;
  DepthImage coarse_depth_m;  // every kCoarseStep-th pixel of the frame's
};

// Of short captures every frame; of long ones every second, fourth ..., so that no more than
// `capacity` (2 or more) are held.
class CoarseViews {
 public:
  explicit CoarseViews(std::size_t capacity = 2048) : capacity_(capacity) {}

  void Add(FrameIdx frame, const Pose3& camera_from_world, const DepthImage& depth_m);

  [[nodiscard]] std::size_t num_held() const { return held_.size(); }

  // How many of all frames that were added the predicate holds for, by those that are held.
  template <typename Predicate>
  [[nodiscard]] double NumThat(const Predicate& holds) const {
    return static_cast<double>(every_) *
           static_cast<double>(std::count_if(held_.begin(), held_.end(), holds));
  }

 private:
  std::size_t capacity_;
  std::size_t every_ = 1;
  std::size_t num_added_ = 0;
  std::vector<CoarseView> held_;
};

}  // namespace deepslam::associate
