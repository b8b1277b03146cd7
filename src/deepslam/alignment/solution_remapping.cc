#include "deepslam/alignment/solution_remapping.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "deepslam/alignment/alignment_system.h"
#include "deepslam/alignment/degenerate_directions.h"
#include "deepslam/alignment/weak_direction_search.h"

namespace deepslam::alignment {
namespace {

// Ends that are as near to the start as half of all motions are not questioned (0.67 standard
// deviations).
constexpr double kNearSigmas = 0.7;
// Places on the way from the start that are compared with the end: at a wall two metres off they
// are a pixel or two apart for the motions of a hand.
constexpr int kNumPlaces = 8;

double SigmasOf(const Vector6d& motion, const StartSigma& sigma) {
  const double sigma_m = std::hypot(sigma.translation_m, kPredictionSigma.translation_m);
  const double sigma_rad = std::hypot(sigma.rotation_rad, kPredictionSigma.rotation_rad);
  return std::hypot(motion.head<3>().norm() / sigma_m, motion.tail<3>().norm() / sigma_rad);
}

// The directions that depth alone does not show.
DegenerateDirections Unseen(const AlignmentSystem& system) {
  if (!ComparesImages(system.num_photometric)) return DegenerateDirections(system.hessian);
  return DegenerateDirections(system.hessian - system.photometric_hessian);
}

// Iterated on from a place, but not along the directions.
GaussNewtonState HeldAt(const Pose3& i_from_j,
                        const FinestLevel& finest,
                        const DegenerateDirections& unseen,
                        const GaussNewtonState& end) {
  GaussNewtonState state = end;
  state.fixed = unseen;
  state.i_from_j = i_from_j;
  Iterate(finest.i, finest.j, finest.options, state);
  MeasureEnd(finest, state);
  return state;
}

// The end brought to a share of its way from the start along the directions, and held there.
GaussNewtonState HeldBetween(double share,
                             const FinestLevel& finest,
                             const FirstStart& start,
                             const DegenerateDirections& unseen,
                             const GaussNewtonState& end) {
  const Vector6d moved = T2v(end.i_from_j * start.i_from_j.Inverse());
  const Pose3 place = V2t(moved - (1 - share) * unseen.Component(moved)) * start.i_from_j;
  return HeldAt(place, finest, unseen, end);
}

}  // namespace

void MeasureEnd(const FinestLevel& finest, GaussNewtonState& state) {
  AlignmentGates gates = state.gates;
  gates.cross_frames = true;
  gates.batch_stride = finest.batch_stride;
  state.system =
      BuildAlignmentSystem(finest.i, finest.j, state.i_from_j, gates, finest.options.pyramid.noise);
  state.stride = finest.j.choice().stride;
}

GaussNewtonState Remapped(const FinestLevel& finest,
                          const FirstStart& start,
                          const GaussNewtonState& end) {
  const DegenerateDirections unseen = Unseen(end.system);
  if (unseen.empty()) return end;
  const auto texture =
      SearchTexture(finest.frame_i, finest.frame_j, unseen, start, end.i_from_j, finest.options);
  if (texture && texture->is_end) return end;
  if (texture) {
    GaussNewtonState state = HeldAt(texture->i_from_j, finest, unseen, end);
    state.fixed_sigma = texture->sigma;
    return state;
  }
  if (!ComparesImages(end.system.num_photometric))
    return HeldBetween(0, finest, start, unseen, end);
  const Vector6d moved = unseen.Component(T2v(end.i_from_j * start.i_from_j.Inverse()));
  const double sigmas = SigmasOf(moved, start.sigma);
  if (sigmas < kNearSigmas) return end;
  const SourceChoice choice{finest.j.choice().stride, finest.options.photometric, false};
  const SourcePoints points(finest.j.level(), choice);
  const auto log_posterior = [&](const GaussNewtonState& state, double share) {
    return SharedInformation(finest.i, points, state.i_from_j, finest.options) -
           0.5 * std::pow(share * sigmas, 2);
  };
  std::vector<GaussNewtonState> held;
  std::vector<double> values;
  for (int n = 0; n < kNumPlaces; ++n) {
    const double share = static_cast<double>(n) / kNumPlaces;
    held.push_back(HeldBetween(share, finest, start, unseen, end));
    values.push_back(log_posterior(held.back(), share));
  }
  const double most = std::max(log_posterior(end, 1), std::ranges::max(values));
  const auto first =
      std::ranges::find_if(values, [&](double value) { return value + kSureNats >= most; });
  return first == values.end() ? end : held[static_cast<std::size_t>(first - values.begin())];
}

}  // namespace deepslam::alignment
