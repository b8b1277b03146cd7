#include "deepslam/loop/shared_place.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>

#include "deepslam/loop/point_agreement.h"
#include "deepslam/loop/sightings.h"

namespace deepslam::loop {
namespace {

// Share of the host's confidence from which on it is open which of the two is there.
constexpr double kAsSure = 0.5;
constexpr double kPieceShare = 0.8;  // of what was measured; the rest is noise at its outline

double Apart_m(const MapObject& a, const MapObject& b) {
  return (a.world_from_object.translation_m - b.world_from_object.translation_m).norm();
}

const MapObject& Get(const ObjectMap& map, ObjectId id) {
  return *std::ranges::find(map.objects, id, &MapObject::id);
}

bool IsPieceOf(ObjectId piece, ObjectId whole, const LoopEvidence& evidence, double radius_m) {
  const auto own = evidence.find(piece);
  const auto other = evidence.find(whole);
  if (own == evidence.end() || other == evidence.end()) return false;
  const std::vector<Eigen::Vector3f> points =
      Thinned(own->second.depth_points_world, kThinnedCell_m);
  std::vector<Eigen::Vector3f> surface = Thinned(other->second.model_points_world, kThinnedCell_m);
  std::ranges::copy(Thinned(other->second.depth_points_world, kThinnedCell_m),
                    std::back_inserter(surface));
  return points.size() >= kMinComparedPoints &&
         AgreeingShare(points, {}, PointIndex(std::move(surface)), radius_m) >= kPieceShare;
}

}  // namespace

bool SharePlace(const MapObject& a, const MapObject& b) {
  return Apart_m(a, b) < LoopOptions::kOverlapShare * 0.5 * std::min(a.scale_m, b.scale_m);
}

std::vector<Duplicate> SuspectDuplicates(const ObjectMap& map,
                                         const LoopOptions& options,
                                         std::span<const int> part_of_frame) {
  std::vector<Duplicate> suspects;
  if (!options.merge_overlapping) return suspects;
  const Sightings sightings(map, {}, {}, part_of_frame);
  for (std::size_t k = 0; k < map.objects.size(); ++k) {
    const MapObject& object = map.objects[k];
    for (std::size_t h = 0; h < map.objects.size(); ++h) {
      const MapObject& host = map.objects[h];
      if (h != k && object.confidence < kAsSure * host.confidence &&
          Apart_m(object, host) < 0.5 * (object.scale_m + host.scale_m) && sightings.Tied(k, h)) {
        suspects.push_back({object.id, host.id});
      }
    }
  }
  return suspects;
}

std::vector<Duplicate> FindDuplicates(const std::vector<Duplicate>& suspects,
                                      const ObjectMap& map,
                                      const LoopEvidence& evidence) {
  const auto confidence = [&](ObjectId id) { return Get(map, id).confidence; };
  const auto stands_in = [&](const Duplicate& suspect) {
    const MapObject& object = Get(map, suspect.id);
    const MapObject& host = Get(map, suspect.host);
    return (object.class_name == host.class_name && SharePlace(object, host)) ||
           IsPieceOf(suspect.id, suspect.host, evidence, LoopOptions::kVerifyDistance_m);
  };
  // Hosts are surer than what stands in them: their own fate is known first, and what leaves the
  // map itself is nobody's host.
  std::vector<Duplicate> surest_first = suspects;
  std::ranges::stable_sort(surest_first, [&](const Duplicate& a, const Duplicate& b) {
    return confidence(a.id) != confidence(b.id) ? confidence(a.id) > confidence(b.id)
                                                : confidence(a.host) > confidence(b.host);
  });
  std::map<ObjectId, ObjectId> host_of;
  for (const Duplicate& suspect : surest_first) {
    if (host_of.contains(suspect.id) || host_of.contains(suspect.host)) continue;
    if (stands_in(suspect)) host_of.emplace(suspect.id, suspect.host);
  }
  std::vector<Duplicate> duplicates;
  std::ranges::copy_if(suspects, std::back_inserter(duplicates), [&](const Duplicate& suspect) {
    const auto host = host_of.find(suspect.id);
    return host != host_of.end() && host->second == suspect.host;
  });
  return duplicates;
}

}  // namespace deepslam::loop
