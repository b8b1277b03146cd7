// Cuts the views of every object out of the frames: crops of colour, depth and silhouette with
// camera and ground.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <vector>

#include "deepslam/core/ids.h"
#include "deepslam/core/options.h"
#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/object_view.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::observe {

struct ViewOptions {
  int max_views = 24;  // per object
  // The crop is the box widened by this share of its longer side, all round: free space beside an
  // object bounds its size.
  static constexpr double kCropMargin = 0.15;
  double spread_deg = 10;  // views closer than this in direction count as repeats and rank lower
  // Factor on the rank of views that touch the image border: they show part of the object only.
  static constexpr double kBorderPenalty = 0.5;
};
void Describe(OptionsVisitor& visitor, ViewOptions& options);

// Which segments of every track become its views: at most max_views, chosen by score, visible size
// and spread of viewpoints; ascending frames. A track without usable segments has none. Points into
// `segments`.
using ViewPlan = std::map<ObjectId, std::vector<const Segment*>>;
[[nodiscard]] ViewPlan PlanObjectViews(const Trajectory& trajectory,
                                       std::span<const Segment> segments,
                                       std::span<const ObjectTrack> tracks,
                                       const ViewOptions& options);

// Memory that the views of these segments take, at most.
[[nodiscard]] std::size_t NumBytes(std::span<const Segment* const> planned,
                                   const PinholeCamera& camera);

enum class ViewContent {
  kDepth,  // colour_crop stays empty: decoding colour is half of a frame's time
  kColourAndDepth,
};

// The views of a plan, ascending id then frame; frames are read in parallel, each once. Those that
// cannot be read, or do not fit their segments, are left out with a warning; an object none of
// whose frames can be read has an empty list. Errors: Interrupted only.
[[nodiscard]] Result<std::map<ObjectId, std::vector<ObjectView>>> CutObjectViews(
    const FrameSource& frames,
    const Trajectory& trajectory,
    const Ground& ground,
    const ViewPlan& plan,
    ViewContent content,
    Progress& progress);

// Both at once, for few objects: all views are held together.
[[nodiscard]] Result<std::map<ObjectId, std::vector<ObjectView>>> CollectObjectViews(
    const FrameSource& frames,
    const Trajectory& trajectory,
    const Ground& ground,
    std::span<const Segment> segments,
    std::span<const ObjectTrack> tracks,
    const ViewOptions& options,
    Progress& progress);

}  // namespace deepslam::observe
