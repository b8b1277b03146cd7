#include "deepslam/select/confidence.h"

#include <algorithm>
#include <cmath>

#include "deepslam/core/angles.h"
#include "deepslam/core/check.h"
#include "deepslam/select/placed.h"
#include "deepslam/shape/symmetry.h"

namespace deepslam::select {
namespace {

constexpr double kRightPlaceM = 0.2;  // this and the next two as the header defines a right place
constexpr double kSameTurnRad = 20 * kRadPerDeg;  // but for turns of its symmetry
constexpr double kSameSizeRatio = 1.2;            // ratio
// The fit, and from where on its parts tell no more.
constexpr double kLogit = -4.85;
constexpr double kLeadLogit = 2.1;        // added by a margin of kClearLead over other places
constexpr double kClearLead = 0.15;       // of scores; larger margins tell no more
constexpr double kSeenLogit = 3.1;        // added where kWellSeenShare of the surface was seen
constexpr double kWellSeenShare = 0.4;    // more tells no more
constexpr double kExplainedLogit = 3.35;  // added by a best score of kExplained
constexpr double kUnexplained = 0.6;      // best scores below add nothing, ...
constexpr double kExplained = 0.9;        // ... and above no more
// Of objects whose place no whole model speaks for or against: about the fit's mean.
constexpr double kUsualLead = 0.06;
// Width of the passage from "likely wrong" to "likely right" around good_score.
constexpr double kScoreWidth = 0.08;

bool StandsThere(const CandidateRegistration& other,
                 const MapObject& winner,
                 shape::Symmetry symmetry) {
  const Pose3 winner_from_other = winner.world_from_object.Inverse() * other.world_from_object;
  const double size = other.scale_m / winner.scale_m;
  return winner_from_other.translation_m.norm() <= kRightPlaceM && size <= kSameSizeRatio &&
         size >= 1 / kSameSizeRatio &&
         shape::RotationApart(winner_from_other.rotation, symmetry) <= kSameTurnRad;
}

// How far the value is on its way from `from` to `to`, in [0, 1].
double ShareOf(double value, double from, double to) {
  return std::clamp((value - from) / (to - from), 0.0, 1.0);
}

double Logistic(double x) { return 1 / (1 + std::exp(-x)); }

}  // namespace

PlaceVotes VotesForPlace(const MapObject& winner,
                         const shape::ShapeModel& shape,
                         std::span<const ShapeCandidate> candidates,
                         std::span<const CandidateRegistration> registrations,
                         std::span<const CandidateScore> scores) {
  DEEPSLAM_CHECK(candidates.size() == registrations.size() && candidates.size() == scores.size(),
                 "one registration and one score per candidate");
  const shape::Symmetry symmetry = shape::SymmetryOf(shape);
  const std::vector<bool> placed = Placed(registrations);
  PlaceVotes votes;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (!placed[i] || TraitsOf(candidates[i].source).follows_depth) continue;
    double& best = StandsThere(registrations[i], winner, symmetry) ? votes.here : votes.elsewhere;
    best = std::max(best, scores[i].score);
  }
  return votes;
}

double Confidence(const MapObject& winner,
                  const shape::ShapeModel& shape,
                  std::span<const ShapeCandidate> candidates,
                  std::span<const CandidateRegistration> registrations,
                  std::span<const CandidateScore> scores) {
  const auto own = std::find_if(scores.begin(), scores.end(), [&](const CandidateScore& score) {
    return score.candidate == winner.chosen;
  });
  if (!winner.chosen.valid() || own == scores.end()) return 0;
  const PlaceVotes votes = VotesForPlace(winner, shape, candidates, registrations, scores);
  const double best = std::max(votes.here, votes.elsewhere);
  const double lead = best > 0 ? votes.here - votes.elsewhere : kUsualLead;
  const double explained = best > 0 ? best : own->score;
  const double likely = Logistic(kLogit + kLeadLogit * std::clamp(lead / kClearLead, -1.0, 1.0) +
                                 kSeenLogit * ShareOf(own->seen_share, 0, kWellSeenShare) +
                                 kExplainedLogit * ShareOf(explained, kUnexplained, kExplained));
  const double fit = Logistic((own->score - SelectOptions::kGoodScore) / kScoreWidth);
  const double views = 0.4 + 0.6 * std::min(1.0,
                                            NumRegistered(winner.views) /
                                                std::max(1.0, SelectOptions::kFullConfidenceViews));
  return std::clamp(fit * views * likely, 0.0, 1.0);
}

}  // namespace deepslam::select
