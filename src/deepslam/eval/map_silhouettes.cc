#include "deepslam/eval/map_silhouettes.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "deepslam/core/parallel.h"
#include "deepslam/eval/silhouette.h"
#include "deepslam/frames/for_frames.h"
#include "deepslam/scene/object_map.h"

namespace deepslam::eval {
namespace {

// One object in one frame.
struct View {
  std::size_t object = 0;
  const Segment* segment = nullptr;
};

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

// The views of every object by frame.
std::map<FrameIdx, std::vector<View>> ViewsByFrame(const ObjectMap& map,
                                                   const Association& association,
                                                   const std::vector<Segment>& segments) {
  std::map<DetectionId, const Segment*> usable;
  for (const Segment& segment : segments) {
    if (segment.usable) usable.emplace(segment.detection, &segment);
  }
  std::map<FrameIdx, std::vector<View>> views;
  for (std::size_t i = 0; i < map.objects.size(); ++i) {
    for (const ObjectTrack& track : association.tracks) {
      if (track.id != map.objects[i].id) continue;
      for (const TrackMember& member : track.members) {
        const auto segment = usable.find(member.detection);
        if (segment != usable.end()) views[member.frame].push_back({i, segment->second});
      }
    }
  }
  return views;
}

void Summarise(SilhouetteReport& report) {
  std::vector<double> all;
  std::vector<double> all_px;
  std::vector<double> medians;
  for (ObjectSilhouette& object : report.objects) {
    object.median_iou = Median(object.ious);
    object.median_iou_all_px = Median(object.ious_all_px);
    all.insert(all.end(), object.ious.begin(), object.ious.end());
    all_px.insert(all_px.end(), object.ious_all_px.begin(), object.ious_all_px.end());
    medians.push_back(object.median_iou);
  }
  report.num_views = static_cast<int>(all.size());
  report.median_iou = Median(std::move(all));
  report.median_iou_all_px = Median(std::move(all_px));
  if (!medians.empty())
    report.lowest_object_iou = *std::min_element(medians.begin(), medians.end());
}

// Of all pixels, and of the measured ones.
using Overlaps = std::array<SilhouetteOverlap, 2>;

Overlaps Compare(const View& view,
                 const SegmentedMap& mapped,
                 const Frame& frame,
                 const PinholeCamera& camera) {
  const auto at = static_cast<std::size_t>(frame.idx.value);
  const Pose3 camera_from_object = mapped.map.frames[at].world_from_camera.Inverse() *
                                   mapped.map.map.objects[view.object].world_from_object;
  const Mask mask = view.segment->mask.Unpacked();
  Overlaps overlaps;
  for (const bool measured_only : {false, true}) {
    overlaps[measured_only ? 1 : 0] = CompareSilhouette(mapped.meshes[view.object],
                                                        camera_from_object,
                                                        camera,
                                                        mask,
                                                        frame.depth_m,
                                                        {.leave_out_unmeasured = measured_only});
  }
  return overlaps;
}

}  // namespace

Result<SilhouetteReport> CompareSilhouettes(const SegmentedMap& mapped,
                                            const FrameSource& frames,
                                            Progress& progress) {
  const auto views = ViewsByFrame(mapped.map.map, mapped.association, mapped.segments);
  SilhouetteReport report;
  for (const MapObject& object : mapped.map.map.objects)
    report.objects.push_back({ObjectName(object), object.class_name, {}, {}, 0, 0});
  std::vector<FrameIdx> wanted;
  for (const auto& [frame, of_frame] : views) wanted.push_back(frame);
  const auto compare = [&](const Frame& frame) {
    const std::vector<View>& of_frame = views.at(frame.idx);
    std::vector<Overlaps> overlaps(of_frame.size());
    ParallelFor(of_frame.size(), [&](std::size_t i) {
      overlaps[i] = Compare(of_frame[i], mapped, frame, frames.camera());
    });
    for (std::size_t i = 0; i < of_frame.size(); ++i) {
      const auto& [all_px, measured] = overlaps[i];
      ObjectSilhouette& object = report.objects[of_frame[i].object];
      if (measured.num_model + measured.num_mask > 0) object.ious.push_back(measured.iou);
      if (all_px.num_model + all_px.num_mask > 0) object.ious_all_px.push_back(all_px.iou);
    }
    return Ok();
  };
  if (Status status = ForFrames(frames, wanted, progress, compare); !status.ok())
    return status.error();
  Summarise(report);
  return report;
}

}  // namespace deepslam::eval
