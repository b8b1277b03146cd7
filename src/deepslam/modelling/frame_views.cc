#include "deepslam/modelling/frame_views.h"

#include <map>
#include <utility>

#include "deepslam/observe/own_support.h"

namespace deepslam::modelling {
namespace {

// Segments of which some are the views of tracks.
struct PlannedViews {
  std::vector<Segment> segments;
  observe::ViewPlan plan;  // of them
};

// All segments are looked at for the plan, and the masks of those in it are read then.
Result<PlannedViews> PlanViews(const SegmentStore& segments,
                               const TrackedObjects& objects,
                               const observe::ViewOptions& options) {
  PlannedViews views{{},
                     observe::PlanObjectViews(
                         objects.trajectory, segments.without_masks(), objects.tracks, options)};
  std::set<DetectionId> wanted;
  for (const auto& [object, planned] : views.plan) {
    for (const Segment* segment : planned) wanted.insert(segment->detection);
  }
  Result<std::vector<Segment>> with_masks = segments.Of(wanted);
  if (!with_masks.ok()) return with_masks.error();
  views.segments = std::move(with_masks).value();
  std::map<DetectionId, const Segment*> by_detection;
  for (const Segment& segment : views.segments) by_detection.emplace(segment.detection, &segment);
  for (auto& [object, planned] : views.plan) {
    for (const Segment*& segment : planned) segment = by_detection.at(segment->detection);
  }
  return views;
}

}  // namespace

FrameViews::FrameViews(ViewInputs inputs,
                       const observe::ViewOptions& options,
                       Progress& progress,
                       std::size_t batch_bytes)
    : inputs_(std::move(inputs)),
      options_(options),
      progress_(progress),
      batch_bytes_(batch_bytes) {}

Status FrameViews::ForBatches(const TrackedObjects& objects,
                              observe::ViewContent content,
                              const UseViews& use) const {
  Result<PlannedViews> planned_views = PlanViews(*inputs_.segments, objects, options_);
  if (!planned_views.ok()) return planned_views.error();
  observe::ViewPlan& plan = planned_views->plan;
  const std::span<const ObjectTrack> tracks = objects.tracks;
  for (std::size_t begin = 0; begin < tracks.size();) {
    observe::ViewPlan of_batch;
    std::size_t num_bytes = 0;
    std::size_t end = begin;
    for (; end < tracks.size() && (end == begin || num_bytes < batch_bytes_); ++end) {
      const auto planned = plan.find(tracks[end].id);
      if (planned == plan.end()) continue;
      num_bytes += observe::NumBytes(planned->second, inputs_.frames.camera());
      of_batch.insert(plan.extract(planned));
    }
    auto views = observe::CutObjectViews(
        inputs_.frames, objects.trajectory, objects.ground, of_batch, content, progress_);
    if (!views.ok()) return views.error();
    std::vector<TrackViews> batch;
    for (std::size_t t = begin; t < end; ++t) {
      batch.push_back({&tracks[t], std::move((*views)[tracks[t].id])});
      observe::PutOnOwnSupport(inputs_.classes.TraitsOf(tracks[t].class_name).supports,
                               batch.back().views);
    }
    views->clear();
    if (Status status = use(batch); !status.ok()) return status;
    begin = end;
  }
  return Ok();
}

}  // namespace deepslam::modelling
