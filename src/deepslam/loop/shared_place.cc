#include "deepslam/loop/shared_place.h"

#include <algorithm>

namespace deepslam::loop {
namespace {

// Share of the host's confidence from which on it is open which of the two is there.
constexpr double kAsSure = 0.5;

}  // namespace

bool SharePlace(const MapObject& a, const MapObject& b, const LoopOptions& options) {
  const double apart_m =
      (a.world_from_object.translation_m - b.world_from_object.translation_m).norm();
  return a.class_name == b.class_name &&
         apart_m < options.overlap_share * 0.5 * std::min(a.scale_m, b.scale_m);
}

std::vector<Intruder> FindIntruders(const ObjectMap& map, const LoopOptions& options) {
  std::vector<Intruder> intruders;
  if (!options.merge_overlapping) return intruders;
  for (const MapObject& object : map.objects) {
    const MapObject* host = nullptr;
    for (const MapObject& other : map.objects) {
      if (other.id == object.id || !(object.confidence < kAsSure * other.confidence) ||
          !SharePlace(object, other, options)) {
        continue;
      }
      if (host == nullptr || other.confidence > host->confidence) host = &other;
    }
    if (host != nullptr) intruders.push_back({object.id, host->id});
  }
  return intruders;
}

}  // namespace deepslam::loop
