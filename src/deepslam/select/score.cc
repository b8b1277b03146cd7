#include "deepslam/select/score.h"

#include <algorithm>
#include <cmath>

namespace deepslam::select {
namespace {

constexpr double kFullCount = 100;   // points, or pixels, from which on a view counts in full
constexpr double kGroundFade = 0.1;  // m

}  // namespace

Evidence Pool(std::span<const ViewAgreement> views) {
  Evidence pooled;
  double point_weight = 0;
  double pixel_weight = 0;
  for (const ViewAgreement& view : views) {
    const double points = std::min(1.0, view.num_points / kFullCount);
    const double pixels = std::min(1.0, view.num_seen / kFullCount);
    point_weight += points;
    pixel_weight += pixels;
    pooled.surface += points * view.surface;
    pooled.reached += points * view.reached;
    pooled.coverage += pixels * view.coverage;
    pooled.violation += pixels * view.violation;
    if (points > 0) ++pooled.num_views;
  }
  if (point_weight > 0) {
    pooled.surface /= point_weight;
    pooled.reached /= point_weight;
  }
  if (pixel_weight > 0) {
    pooled.coverage /= pixel_weight;
    pooled.violation /= pixel_weight;
  } else {
    pooled.coverage = pooled.surface / 3;  // makes the harmonic mean half of S
  }
  return pooled;
}

double ScoreOf(const Evidence& evidence, double ground_excess_m) {
  const double sum = evidence.surface + evidence.coverage;
  if (!(sum > 0) || !std::isfinite(ground_excess_m)) return 0;
  const double excess = std::max(0.0, ground_excess_m) / kGroundFade;
  const double ground = std::exp(-0.5 * excess * excess);
  return std::clamp(ground * 2 * evidence.surface * evidence.coverage / sum, 0.0, 1.0);
}

double ScoreWithinReach(const CandidateScore& score) {
  const double surface = score.surface_share;
  const double coverage = score.coverage_share;
  if (!(surface > 0) || !(coverage > 0) || !(score.reached_share > 0)) return score.score;
  const double within = std::min(1.0, surface / score.reached_share);
  const double factor = (within / (within + coverage)) / (surface / (surface + coverage));
  return std::clamp(score.score * factor, score.score, 1.0);
}

}  // namespace deepslam::select
