// The things of a capture, found in the surface of all its frames: what is not floor, wall or
// ceiling is divided by its shape and by the votes of all detections (instances), and each thing's
// silhouette in a frame is the part of the frame that lies on it.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "deepslam/core/options.h"
#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/instances/find_instances.h"
#include "deepslam/instances/silhouettes.h"
#include "deepslam/instances/structure.h"
#include "deepslam/scene/coarse_surface.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/layout.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/trajectory.h"
#include "deepslam/segment/segment_objects.h"

namespace deepslam::discovery {

struct ThingOptions {
  instances::StructureOptions structure;
  instances::InstanceOptions instances;
  instances::SilhouetteOptions silhouettes;
  segment::SegmentOptions cut;  // of the silhouettes, along depth edges
};
void Describe(OptionsVisitor& visitor, ThingOptions& options);

struct ThingInputs {
  const FrameSource& frames;
  const Trajectory& trajectory;
  const CoarseSurface& surface;  // of these frames
  const Layout& layout;          // of this surface
  const ClassTable& classes;
  // Ascending: frames whose silhouettes are wanted, and those that the detector looked at, of which
  // others only vote.
  std::span<const FrameIdx> wanted;
  std::span<const FrameIdx> looked_at;
  std::span<const Detection> detections;  // of these frames, in ascending frames
  int next_detection_id = 0;              // above the ids of all detections of the capture
};

struct FoundThings {
  // One track per thing that is an object of the map, ids from 0; every detection that names none
  // of them is among the rejections; things of some size that are no objects are told of.
  Association association;
  // One per thing and frame that shows enough of it, ascending frames: what the tracks' members
  // name. Where a detection of the frame is of the thing the segment has its id and score;
  // otherwise an id above those of all detections.
  std::vector<Segment> segments;
};

// Frames that cannot be read are left out with a warning. Errors: Interrupted only.
[[nodiscard]] Result<FoundThings> FindThings(const ThingInputs& inputs,
                                             const ThingOptions& options,
                                             Progress& progress);

}  // namespace deepslam::discovery
