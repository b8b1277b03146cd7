#include "deepslam/instances/class_sizes.h"

#include <algorithm>

namespace deepslam::instances {
namespace {

// A class names nothing of which less than this share of its least length was seen: a cushion is no
// bed.
constexpr double kMinSeenShare = 0.5;

// The longest side of things of a class is level where the least is this many times as long as the
// least height: beds, not chairs.
constexpr double kLies = 2;

}  // namespace

bool MayBe(const ObjectClass& object_class, const UprightBox& box) {
  const double longest_m = std::max(box.long_side_m(), box.height_m());
  const bool lies = object_class.min_size_m > kLies * object_class.min_height_m;
  return (lies ? box.long_side_m() : longest_m) >= kMinSeenShare * object_class.min_size_m &&
         longest_m <= object_class.max_size_m && box.height_m() <= object_class.max_height_m;
}

}  // namespace deepslam::instances
