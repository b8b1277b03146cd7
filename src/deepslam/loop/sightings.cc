#include "deepslam/loop/sightings.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace deepslam::loop {

Sightings::Sightings(const ObjectMap& map,
                     const Association& association,
                     const Trajectory& trajectory,
                     std::span<const int> part_of_frame)
    : part_of_frame_(part_of_frame.begin(), part_of_frame.end()) {
  std::map<ObjectId, const ObjectTrack*> tracks;
  for (const ObjectTrack& track : association.tracks) tracks.emplace(track.id, &track);
  for (const MapObject& object : map.objects) {
    std::vector<int> frames;
    for (const ViewRegistration& view : object.views) frames.push_back(view.frame.value);
    std::vector<ObjectId> ids = object.merged;
    ids.push_back(object.id);
    for (const ObjectId id : ids) {
      const auto track = tracks.find(id);
      if (track == tracks.end()) continue;
      for (const TrackMember& member : track->second->members) frames.push_back(member.frame.value);
    }
    std::sort(frames.begin(), frames.end());
    frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
    frames_.push_back(std::move(frames));
  }

  // Keyframes only: the jitter of single frames is not travel.
  const Eigen::Vector3d* previous = nullptr;
  for (const FrameIdx keyframe : trajectory.keyframes) {
    if (!keyframe.valid() || keyframe.value >= static_cast<int>(trajectory.frames.size())) continue;
    const Eigen::Vector3d& here = trajectory.at(keyframe).world_from_camera.translation_m;
    const double step_m = previous == nullptr ? 0.0 : (here - *previous).norm();
    const double before_m = path_m_.empty() ? 0.0 : path_m_.back();
    path_frames_.push_back(keyframe.value);
    path_m_.push_back(before_m + (std::isfinite(step_m) ? step_m : 0.0));
    previous = &here;
  }
}

bool Sightings::SeenTogether(std::size_t a, std::size_t b) const {
  const std::vector<int>& other = frames_[b];
  return std::any_of(frames_[a].begin(), frames_[a].end(), [&other](int frame) {
    return std::binary_search(other.begin(), other.end(), frame);
  });
}

int Sightings::PartOf(std::size_t object) const {
  const int first = frames_[object].empty() ? -1 : frames_[object].front();
  const bool known = 0 <= first && first < static_cast<int>(part_of_frame_.size());
  return known ? part_of_frame_[static_cast<std::size_t>(first)] : 0;
}

bool Sightings::Tied(std::size_t a, std::size_t b) const { return PartOf(a) == PartOf(b); }

double Sightings::PathUntil_m(int frame) const {
  const auto after = std::upper_bound(path_frames_.begin(), path_frames_.end(), frame);
  if (after == path_frames_.begin()) return 0;
  return path_m_[static_cast<std::size_t>(after - path_frames_.begin()) - 1];
}

double Sightings::PathBetween_m(int frame_a, int frame_b) const {
  return std::abs(PathUntil_m(frame_a) - PathUntil_m(frame_b));
}

}  // namespace deepslam::loop
