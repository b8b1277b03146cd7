#include "deepslam/modelling/loop_world.h"

#include <algorithm>
#include <utility>

#include "deepslam/scene/measured_parts.h"

namespace deepslam::modelling {

MapObject* FindObject(ObjectMap& map, ObjectId id) {
  const auto found = std::ranges::find(map.objects, id, &MapObject::id);
  return found == map.objects.end() ? nullptr : &*found;
}

ObjectTrack* FindTrack(Association& association, ObjectId id) {
  const auto found = std::ranges::find(association.tracks, id, &ObjectTrack::id);
  return found == association.tracks.end() ? nullptr : &*found;
}

void EraseTrack(Association& association, ObjectId id) {
  std::erase_if(association.tracks, [&](const ObjectTrack& track) { return track.id == id; });
}

std::vector<int> PartsOf(const LoopWorld& world) {
  return PartsOfFrames(world.odometry, JoinsOf(world.odometry, world.edges));
}

std::vector<CandidateRegistration> PlacedRegistrations(const LoopWorld& world) {
  std::vector<CandidateRegistration> placed;
  for (const MapObject& object : world.map.objects) {
    const auto own = world.registrations.find(object.id);
    if (own == world.registrations.end()) continue;
    const auto chosen =
        std::ranges::find(own->second, object.chosen, &CandidateRegistration::candidate);
    const Pose3 now_from_then =
        chosen == own->second.end() || !chosen->ok
            ? Pose3{}
            : object.world_from_object * chosen->world_from_object.Inverse();
    for (CandidateRegistration registration : own->second) {
      registration.world_from_object = now_from_then * registration.world_from_object;
      placed.push_back(std::move(registration));
    }
  }
  return placed;
}

}  // namespace deepslam::modelling
