// The shapes that a person chose for objects.
#pragma once

#include <span>

#include "deepslam/core/ids.h"
#include "deepslam/core/result.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/overrides.h"
#include "deepslam/scene/shape_candidate.h"

namespace deepslam::overrides {

// Every `choose` names one of `tracks`, to which all else was applied (else kInvalidConfig, naming
// file, line and what is known).
[[nodiscard]] Status CheckChoices(const Overrides& overrides, std::span<const ObjectTrack> tracks);

// The candidate chosen for an object, invalid where nothing was: one of `candidates`, which are the
// object's, by number or by model (else kInvalidConfig, as above).
[[nodiscard]] Result<CandidateId> ChosenByHand(const Overrides& overrides,
                                               ObjectId object,
                                               std::span<const ShapeCandidate> candidates);

}  // namespace deepslam::overrides
