// Cuts the views of every object out of the frames: crops of colour, depth and silhouette with
// camera and ground.
#pragma once

#include <map>
#include <span>
#include <vector>

#include "deepslam/core/ids.h"
#include "deepslam/core/options.h"
#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/frame_source.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/object_view.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::observe {

struct ViewOptions {
  int max_views = 24;  // per object
  double crop_margin =
      0.15;  // the crop is the box widened by this share of its longer side, all round
  double spread_deg = 10;  // views closer than this in direction count as repeats and rank lower
  double border_penalty = 0.5;  // factor on the rank of views that touch the image border
};
void Describe(OptionsVisitor& visitor, ViewOptions& options);

// Views of every track, ascending id then frame; at most max_views per object, chosen by score,
// visible size and spread of viewpoints. A track none of whose frames can be read has an empty
// list. Errors: Interrupted only.
[[nodiscard]] Result<std::map<ObjectId, std::vector<ObjectView>>> CollectObjectViews(
    const FrameSource& frames,
    const Odometry& odometry,
    const Ground& ground,
    std::span<const Segment> segments,
    std::span<const ObjectTrack> tracks,
    const ViewOptions& options,
    Progress& progress);

}  // namespace deepslam::observe
