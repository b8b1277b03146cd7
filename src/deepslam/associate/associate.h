// Object matching (paper, section "Object matching"): which detections of a capture are the same
// physical object.
//
// Each detection of a frame collects votes of the previous detected frames: the depth points of
// their segments, moved into this frame by the tracked poses, that fall inside its box and lie near
// its own points. Without a consensus the objects that have no detection in this frame yet are
// tried with all their points; only then a new object starts.
//
// Places are compared within a part of the path (scene/measured_parts.h): where tracking found
// nothing in common with the frames before, the world goes on at the last pose, and what stands in
// one place may stand in two rooms. What loops tie together later, loops merge.
#pragma once

#include <span>
#include <vector>

#include "deepslam/core/options.h"
#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::associate {

struct AssociateOptions {
  // Previous detected frames that vote, as many as in the paper.
  static constexpr int kNumVoteFrames = 5;
  // Mean closest-point distance up to which two point sets are one object: drift over some frames
  // and the depth's noise. Chairs at a table stand farther apart.
  static constexpr double kMaxDissimilarity_m = 0.10;
  // Single distances count no more than this: parts that are hidden or new lie farther off.
  static constexpr double kMaxCounted_m = 0.30;
  // Share of a voter's points that fall inside the box: more than half cannot be of two things.
  static constexpr double kMinInsideShare = 0.5;
  static constexpr double kMinConsensus = 0.5;  // of the votes name the winner, for the same reason
  // Per segment, thinned evenly: one per 5 cm square of a sofa seen from one side.
  static constexpr int kMaxSegmentPoints = 800;
  int min_members = 3;  // objects with fewer detections are dropped as noise, ...
  // ... unless the mean score of their detections is this high: more likely right than not.
  static constexpr double kMinSingleScore = 0.5;
  // Objects detected in a smaller share of the frames that see them are noise: a detector that
  // misses one in six frames of seven is more likely wrong in the seventh.
  static constexpr double kMinDetectedShare = 0.15;
  // Objects too large for the image never keep the border margin: where the boxes that found no
  // object agree with each other, span at least this share of the image's width or height (median)
  // and are `min_members` or more, they start one after all. 1 or more: never, as in the paper.
  double border_span = 0.6;
  // So do boxes that agree and are this many, however small: a thing at the rim of everything the
  // camera saw. 0: never, as in the paper.
  int border_members = 8;
  // Two objects of which the smaller shares more of its space are one: two things share no half.
  static constexpr double kMergeOverlap = 0.5;
  // Cells in which objects' space is compared: larger than the depth's noise, and than the steps
  // between the points of a segment.
  static constexpr double kVoxel_m = 0.05;
};
void Describe(OptionsVisitor& visitor, AssociateOptions& options);

// `part_of_frame`: of each frame of the trajectory. `segments` of the whole capture in ascending
// frames; masks are let go behind their frame. Every detection ends in exactly one track or one
// rejection; one detection per object and frame. Ids count from 0 in the order in which objects
// appear; a merged object keeps the lower id. Frames whose depth cannot be read reject their
// detections. Errors: Interrupted only.
[[nodiscard]] Result<Association> Associate(const FrameSource& frames,
                                            const Trajectory& trajectory,
                                            std::span<const int> part_of_frame,
                                            std::vector<Segment> segments,
                                            const AssociateOptions& options,
                                            Progress& progress);

}  // namespace deepslam::associate
