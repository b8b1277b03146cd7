// From evidence per view to one score: how well model and measurement explain each other where both
// can be seen.
#pragma once

#include <span>

#include "deepslam/scene/object_map.h"

namespace deepslam::select {

struct Evidence {
  double surface = 0;    // S: share of the object's depth that lies on the model
  double coverage = 0;   // C: share of the model's visible surface that the depth confirms
  double violation = 0;  // part of 1 - C: rays that pass through the model
  int num_views = 0;     // views that said anything
  double reached = 0;    // R: share of the object's depth that is not far off the model
};

// Mean over views, each with the weight min(1, count / 100) of its points (S) or pixels (C): near
// views have more pixels, not more to say.
[[nodiscard]] Evidence Pool(std::span<const ViewAgreement> views);

// score = ground * 2 S C / (S + C), in [0, 1].
//
// S is what a too small, shifted or incomplete model loses; C is what a too large or filled one
// loses (a solid block round a chair holds depth points inside it, and rays pass through it). Their
// harmonic mean is near the worse of both, so neither can be bought with the other, and size as
// such earns nothing. What nobody measured counts for nothing. ground = exp(-(excess / 0.1 m)^2 /
// 2) with the excess of the gap between the model's bottom and the ground over its tolerance:
// furniture stands. A model of which nothing can be scored (C unknown) gets half of S.
[[nodiscard]] double ScoreOf(const Evidence& evidence, double ground_excess_m);

// The score of a whole model if the object's depth out of its reach were of something else: S / R
// in place of S.
[[nodiscard]] double ScoreWithinReach(const CandidateScore& score);

}  // namespace deepslam::select
