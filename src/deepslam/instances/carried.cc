#include "deepslam/instances/carried.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "deepslam/geometry/level_rectangle.h"

namespace deepslam::instances {
namespace {

constexpr double kMinShareOver = 0.5;  // of the outline of what rests on something
// Between what carries and what rests on it: the surface has gaps where things touch, and the top
// of the one and the foot of the other are told to a few centimetres.
constexpr double kMaxGapBelowM = 0.12;
// Things stand deeper than a box's top where that is its highest point only.
constexpr double kMaxSinkM = 0.15;
// Between the lowest tables and the highest counters on which things stand; wall cabinets begin
// half a metre above counters.
constexpr double kLowestTopM = 0.75;
constexpr double kHighestTopM = 1.2;  // bar counters are 1.1 m high
constexpr double kLongestLoadM = 1;   // longer ones are tops themselves

double VolumeOf(const UprightBox& box) { return OutlineOf(box).area_m2() * box.height_m(); }

bool RestsOn(const UprightBox& thing, const UprightBox& other) {
  const double above_m = thing.bottom_m - other.top_m;
  if (above_m > kMaxGapBelowM || above_m < -kMaxSinkM || VolumeOf(other) < VolumeOf(thing))
    return false;
  const LevelRectangle outline = OutlineOf(thing);
  return SharedArea(outline, OutlineOf(other)) > kMinShareOver * outline.area_m2();
}

bool BeginsAtTops(const UprightBox& thing) {
  return thing.bottom_m > kLowestTopM && thing.bottom_m < kHighestTopM &&
         thing.long_side_m() <= kLongestLoadM;
}

}  // namespace

void RejectCarried(std::span<Instance> instances) {
  std::vector<std::string> reasons(instances.size());
  for (std::size_t i = 0; i < instances.size(); ++i) {
    if (instances[i].is_named || !instances[i].rejection.empty()) continue;
    const auto carrier = std::ranges::find_if(instances, [&](const Instance& other) {
      return &other != &instances[i] && other.rejection.empty() &&
             RestsOn(instances[i].box_level, other.box_level);
    });
    if (carrier != instances.end())
      reasons[i] = fmt::format("stands on a {} and no detection names it", carrier->class_name);
    else if (BeginsAtTops(instances[i].box_level))
      reasons[i] = "stands on something and no detection names it";
  }
  for (std::size_t i = 0; i < instances.size(); ++i) {
    if (!reasons[i].empty()) instances[i].rejection = reasons[i];
  }
}

}  // namespace deepslam::instances
