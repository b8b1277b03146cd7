// How likely a selected object stands where it is said to.
#pragma once

#include <span>

#include "deepslam/scene/object_map.h"
#include "deepslam/scene/registration.h"
#include "deepslam/scene/shape_candidate.h"
#include "deepslam/select/select_options.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::select {

// What whole models say of the winner's place: the best score of one that stands where the winner
// does (within 20 cm, 20 deg, 20 % of size), and of one that stands elsewhere; 0 where there is
// none. Turns that leave the winner's shape as it is are no turns.
struct PlaceVotes {
  double here = 0;
  double elsewhere = 0;
};

// What is made of the object's depth does not vote, as it agrees wherever it stands; nor do models
// that are not placed. `registrations` and `scores`: one per candidate.
[[nodiscard]] PlaceVotes VotesForPlace(const MapObject& winner,
                                       const shape::ShapeModel& shape,
                                       std::span<const ShapeCandidate> candidates,
                                       std::span<const CandidateRegistration> registrations,
                                       std::span<const CandidateScore> scores);

// Likelihood that the winner stands within 20 cm, 20 deg and 20 % of size of the truth: a logistic
// function of the lead of its place over others, of how well any whole model explains the object,
// and of the share of its surface that views show, fitted to rendered rooms (docs/evaluation.md,
// "Confidence"). Where its own score is near or below good_score, and with fewer than
// full_confidence_views, nothing was fitted, and it falls. 0 for an object without a winner.
[[nodiscard]] double Confidence(const MapObject& winner,
                                const shape::ShapeModel& shape,
                                std::span<const ShapeCandidate> candidates,
                                std::span<const CandidateRegistration> registrations,
                                std::span<const CandidateScore> scores);

}  // namespace deepslam::select
