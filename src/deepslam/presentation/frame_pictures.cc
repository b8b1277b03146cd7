#include "deepslam/presentation/frame_pictures.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <map>

#include <fmt/format.h>

#include "deepslam/geometry/upright.h"
#include "deepslam/presentation/pictured_object.h"
#include "deepslam/report/draw.h"
#include "deepslam/scene/upright_turns.h"

namespace deepslam::presentation {
namespace {

constexpr int kMaxFramePictures = 6;  // an overview; each is a picture more to read and to load

// Colours that neighbours in the list do not share; by id, so that an object keeps its colour over
// frames.
Rgb8 InstanceColour(int id) {
  constexpr std::array<Rgb8, 10> kPalette{{{230, 57, 70},
                                           {29, 121, 199},
                                           {42, 157, 78},
                                           {244, 162, 30},
                                           {123, 44, 191},
                                           {0, 170, 170},
                                           {214, 82, 160},
                                           {130, 110, 40},
                                           {90, 90, 220},
                                           {140, 190, 40}}};
  return kPalette[static_cast<std::size_t>(id) % kPalette.size()];
}

}  // namespace

std::vector<FrameIdx> FramesToPicture(std::span<const Segment> segments,
                                      const OptimizedMap& map,
                                      const std::set<FrameIdx>& shown) {
  std::set<FrameIdx> segmented;
  for (const Segment& segment : segments) segmented.insert(segment.frame);
  std::vector<FrameIdx> all;
  std::ranges::copy_if(map.keyframes, std::back_inserter(all), [&](FrameIdx keyframe) {
    return segmented.contains(keyframe) && shown.contains(keyframe);
  });
  return Spread(all, kMaxFramePictures);
}

std::vector<report::Picture> FramePictures(std::span<const FrameIdx> wanted,
                                           std::span<const Segment> segments,
                                           std::span<const ObjectTrack> tracks,
                                           const OptimizedMap& map,
                                           const FrameSource& frames) {
  std::map<DetectionId, ObjectId> object_of;
  for (const ObjectTrack& track : tracks) {
    for (const TrackMember& member : track.members) object_of[member.detection] = track.id;
  }
  std::map<FrameIdx, std::vector<const Segment*>> in_frame;
  for (const Segment& segment : segments) in_frame[segment.frame].push_back(&segment);
  const PinholeCamera& camera = frames.camera();
  const auto overlay_of = [&](const Segment& s, QuarterTurn upright) {
    const auto object = object_of.find(s.detection);
    report::Overlay overlay{Turned(s.box_px, camera.width, camera.height, upright),
                            Turned(s.mask.Unpacked(), upright),
                            fmt::format("{} {:.2f}", s.class_name, s.score),
                            Rgb8{150, 150, 150}};
    if (object != object_of.end()) {
      overlay.colour = InstanceColour(object->second.value);
      overlay.label = fmt::format("{}_{:02d} {:.2f}", s.class_name, object->second.value, s.score);
    }
    return overlay;
  };
  std::vector<report::Picture> pictures;
  for (const FrameIdx keyframe : wanted) {
    const Result<Frame> frame = frames.ReadColour(keyframe);
    if (!frame.ok()) continue;
    const QuarterTurn upright = UprightTurnIn(map, keyframe);
    std::vector<report::Overlay> overlays;
    for (const Segment* segment : in_frame[keyframe])
      overlays.push_back(overlay_of(*segment, upright));
    AddPicture(pictures,
               report::DrawOverlays(Turned(frame->colour, upright), overlays, 520),
               fmt::format("frame {}", keyframe.value));
  }
  return pictures;
}

}  // namespace deepslam::presentation
