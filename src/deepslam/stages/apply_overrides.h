// A person's corrections, applied to the values of the stages they concern. Every function returns
// one sentence per correction applied; errors (kInvalidConfig) name file, line and what is known.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "deepslam/artifact/overrides_yaml.h"
#include "deepslam/core/result.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/shape_candidate.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::stages {

// Split, then merge, relabel, drop; parts of a split object get the next free ids, in the order of
// the file. The detections of dropped objects become rejections.
[[nodiscard]] Result<std::vector<std::string>> ApplyToTracks(const artifact::Overrides& overrides,
                                                             const ClassTable& classes,
                                                             Association& association);

// Ground that agrees with the hint (10 degrees, 0.15 m) stays; all other is left out, and the hint
// stands in for it.
[[nodiscard]] std::vector<std::string> ApplyToGround(const artifact::Overrides& overrides,
                                                     const Trajectory& trajectory,
                                                     Ground& ground);

// Every `choose` names one of `tracks`, to which all else was applied.
[[nodiscard]] Status CheckChoices(const artifact::Overrides& overrides,
                                  std::span<const ObjectTrack> tracks);

// The candidate chosen for an object, invalid where nothing was: one of `candidates`, which are the
// object's, by number or by model.
[[nodiscard]] Result<CandidateId> ChosenByHand(const artifact::Overrides& overrides,
                                               ObjectId object,
                                               std::span<const ShapeCandidate> candidates);

}  // namespace deepslam::stages
