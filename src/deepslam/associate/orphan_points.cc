#include "deepslam/associate/orphan_points.h"

#include <utility>

#include "deepslam/core/check.h"
#include "deepslam/core/every_nth.h"

namespace deepslam::associate {

std::size_t OrphanPoints::Keep(const Points& points) {
  sets_.push_back(EveryNth(points, step_));
  num_points_ += sets_.back().size();
  if (num_points_ > max_points_) {
    step_ *= 2;
    num_points_ = 0;
    for (Points& set : sets_) {
      set = EveryNth(set, 2);
      num_points_ += set.size();
    }
  }
  return sets_.size() - 1;
}

OrphanPoints::Points OrphanPoints::Take(std::size_t key) {
  DEEPSLAM_CHECK(key < sets_.size(), "no set of points has this key");
  num_points_ -= sets_[key].size();
  return std::exchange(sets_[key], {});
}

}  // namespace deepslam::associate
