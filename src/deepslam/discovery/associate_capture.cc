#include "deepslam/discovery/associate_capture.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include "deepslam/discovery/flush_with_wall.h"

namespace deepslam::discovery {
namespace {

struct Divided {
  std::vector<FrameIdx> wanted;       // in the surface's world: keyframes, those of a user's masks
  std::vector<FrameIdx> looked_at;    // in the surface's world
  std::vector<Detection> detections;  // of these frames
  std::vector<Segment> elsewhere;     // of all other frames
};

Divided Divide(const CaptureInputs& inputs, std::vector<Segment> segments) {
  const auto is_elsewhere = [&](FrameIdx frame) {
    return ApartAt(inputs.ground, frame) != nullptr || !IsAligned(inputs.trajectory.at(frame));
  };
  Divided divided;
  for (const FrameIdx frame : inputs.looked_at) {
    if (!is_elsewhere(frame)) divided.looked_at.push_back(frame);
  }
  std::set<FrameIdx> wanted;
  for (const FrameIdx frame : inputs.trajectory.keyframes) {
    if (!is_elsewhere(frame)) wanted.insert(frame);
  }
  for (const Detection& detection : inputs.detections) {
    if (is_elsewhere(detection.frame)) continue;
    divided.detections.push_back(detection);
    if (detection.source == DetectionSource::kFile) wanted.insert(detection.frame);
  }
  divided.wanted.assign(wanted.begin(), wanted.end());
  std::ranges::stable_sort(divided.detections, {}, &Detection::frame);
  for (Segment& segment : segments) {
    if (is_elsewhere(segment.frame)) divided.elsewhere.push_back(std::move(segment));
  }
  return divided;
}

Result<FoundThings> ByVotes(const CaptureInputs& inputs,
                            std::vector<Segment> segments,
                            const associate::AssociateOptions& options,
                            Progress& progress) {
  FoundThings found;
  found.segments = segments;
  Result<Association> association = associate::Associate(inputs.frames,
                                                         inputs.trajectory,
                                                         inputs.part_of_frame,
                                                         std::move(segments),
                                                         options,
                                                         progress);
  if (!association.ok()) return association.error();
  found.association = std::move(association).value();
  return found;
}

// Ids of `more` go on behind those of `all`.
void Append(FoundThings more, FoundThings& all) {
  const int first_id =
      all.association.tracks.empty() ? 0 : all.association.tracks.back().id.value + 1;
  for (ObjectTrack& track : more.association.tracks) {
    track.id.value += first_id;
    all.association.tracks.push_back(std::move(track));
  }
  std::ranges::move(more.association.rejections, std::back_inserter(all.association.rejections));
  std::ranges::move(more.segments, std::back_inserter(all.segments));
  std::ranges::stable_sort(all.segments, {}, &Segment::frame);
}

Result<FoundThings> FindAll(const CaptureInputs& inputs,
                            std::vector<Segment> segments,
                            const associate::AssociateOptions& by_votes,
                            const ThingOptions& by_surface,
                            Progress& progress) {
  if (!inputs.surface || !inputs.surface->surface.has_ground)
    return ByVotes(inputs, std::move(segments), by_votes, progress);
  Divided divided = Divide(inputs, std::move(segments));
  int next_detection_id = 0;
  for (const Detection& detection : inputs.detections)
    next_detection_id = std::max(next_detection_id, detection.id.value + 1);
  const ThingInputs things{inputs.frames,
                           inputs.trajectory,
                           inputs.surface->surface,
                           inputs.surface->layout,
                           inputs.classes,
                           divided.wanted,
                           divided.looked_at,
                           divided.detections,
                           next_detection_id};
  Result<FoundThings> found = FindThings(things, by_surface, progress);
  if (!found.ok() || divided.elsewhere.empty()) return found;
  Result<FoundThings> elsewhere = ByVotes(inputs, std::move(divided.elsewhere), by_votes, progress);
  if (!elsewhere.ok()) return elsewhere.error();
  Append(std::move(elsewhere).value(), *found);
  return found;
}

}  // namespace

Result<FoundThings> AssociateCapture(const CaptureInputs& inputs,
                                     std::vector<Segment> segments,
                                     const associate::AssociateOptions& by_votes,
                                     const ThingOptions& by_surface,
                                     Progress& progress) {
  Result<FoundThings> found = FindAll(inputs, std::move(segments), by_votes, by_surface, progress);
  if (!found.ok()) return found;
  LeaveOutFlush({inputs.frames, inputs.trajectory, inputs.layout, inputs.classes, found->segments},
                found->association);
  return found;
}

}  // namespace deepslam::discovery
