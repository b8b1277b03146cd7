// Which of an object's candidates is its shape: discrete selection by agreement with all depth (the
// paper's "model update"). Agreement is measured in agreement.h, turned into a score in score.h.
#pragma once

#include <span>
#include <string>

#include "deepslam/core/options.h"
#include "deepslam/scene/object_map.h"
#include "deepslam/scene/object_view.h"
#include "deepslam/scene/registration.h"
#include "deepslam/scene/shape_candidate.h"
#include "deepslam/select/agreement.h"
#include "deepslam/select/select_options.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::select {

// Agreement of one candidate, placed by its own registrations, with the depth of all views. A view
// whose registration is not ok is scored at the joint pose, so that no candidate gains by refusing
// the views that speak against it. The result keeps the evidence per view (`views`).
[[nodiscard]] CandidateScore ScoreCandidate(const ShapeCandidate& candidate,
                                            const shape::ShapeModel& model,
                                            const CandidateRegistration& registration,
                                            std::span<const ObjectView> views,
                                            const SelectOptions& options);

// The same with views prepared once for all candidates of an object (PrepareForScoring in
// agreement.h).
[[nodiscard]] CandidateScore ScoreCandidate(const ShapeCandidate& candidate,
                                            const shape::ShapeModel& model,
                                            const CandidateRegistration& registration,
                                            std::span<const ScoredView> views,
                                            const SelectOptions& options);

// The winner and why. The three spans run in parallel: one registration and one score per
// candidate. `history` is the paper's greedy replacement: after each view, in order of frames, the
// best candidate among those proposed so far that are placed (placed.h), by the evidence so far.
// mode "offline": best over all evidence wins; mode "greedy": the last of the history does. Without
// a candidate that could be placed the object comes back with an invalid `chosen` and a note. How
// sure it is, confidence.h says.
[[nodiscard]] MapObject SelectShape(ObjectId id,
                                    const std::string& class_name,
                                    std::span<const ShapeCandidate> candidates,
                                    std::span<const CandidateRegistration> registrations,
                                    std::span<const CandidateScore> scores,
                                    std::span<const ObjectView> views,
                                    const SelectOptions& options);

}  // namespace deepslam::select
