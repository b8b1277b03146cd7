#include "deepslam/alignment/start_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace deepslam::alignment {
namespace {

// Scale of the first step in standard deviations of the noise: far off, every residual must pull.
constexpr float kFirstScale = 12.0F;
constexpr float kFirstPhotometricScale = 25.0F;  // grey levels
// Places that compete at a coarsest level of this width go by every second row and column.
constexpr int kCoarsestStride = 2;
constexpr int kWideCoarsestLevel = 60;  // px: every pixel of narrower ones is needed
// Scale at which competing starts are compared, standard deviations of the noise.
constexpr float kCommonScale = 3.0F;
// At the coarsest level most frames that are laid right have images as like as this and depth that
// fits so well; wrong places along a tiled wall do not reach 0.8 of both.
constexpr double kConclusiveCorrelation = 0.988;
constexpr double kConclusiveInlierRatio = 0.95;  // of the points that overlap

int CoarsestStride(const PyramidLevel& level) {
  return level.camera.width >= kWideCoarsestLevel ? kCoarsestStride : 1;
}

// Where iterations from the starts end, each place once; the first one alone where that is enough.
std::vector<GaussNewtonState> IterateFromAll(std::span<const Pose3> starts,
                                             const StartSearch& search,
                                             const PyramidLevel& i,
                                             const SourcePoints& j,
                                             const AlignmentOptions& options) {
  std::vector<GaussNewtonState> states;
  std::vector<Pose3> tried, ends;
  const auto iterate_from = [&](const Pose3& start) {
    const bool is_new = !IsAmong(tried, start);
    tried.push_back(start);
    if (!is_new) return;
    GaussNewtonState state = StartAt(start);
    state.gates = LevelGates(options, 0);
    state.gates.geometric_scale = kFirstScale;
    state.gates.photometric_scale = kFirstPhotometricScale;
    if (!Iterate(i, j, options, state, ends)) return;
    ends.push_back(state.i_from_j);
    states.push_back(state);
  };
  iterate_from(starts.front());
  if (IsConclusive(states.front().system)) return states;
  for (const Pose3& start : starts.subspan(1)) iterate_from(start);
  if (!search) return states;
  if (const std::optional<Pose3> found = search()) iterate_from(*found);
  return states;
}

}  // namespace

CoarsePoints::CoarsePoints(const PyramidLevel& level, const AlignmentOptions& options)
    : level_(level), options_(options), some_(FarPoints(level, CoarsestStride(level), options)) {}

const SourcePoints& CoarsePoints::all() {
  if (!all_) all_.emplace(FarPoints(level_, 1, options_));
  return *all_;
}

SourcePoints FarPoints(const PyramidLevel& level, int stride, const AlignmentOptions& options) {
  return SourcePoints(level, {stride, options.photometric, false});
}

PlaceScore ScoreCoarsely(const PyramidLevel& i,
                         const SourcePoints& j,
                         const Pose3& i_from_j,
                         const AlignmentOptions& options) {
  CorrespondenceGates gates = LevelGates(options, 0);
  gates.geometric_scale = kCommonScale;
  return ScorePlace(i, j, i_from_j, gates, options.pyramid.noise);
}

double SupportAt(const Pose3& i_from_j,
                 const PyramidLevel& i,
                 const SourcePoints& j,
                 const AlignmentOptions& options) {
  const PlaceScore place = ScoreCoarsely(i, j, i_from_j, options);
  if (place.num_overlap == 0) return 0;
  const double images = place.num_photometric * std::max(0.0, place.intensity_correlation);
  const double per_point = (place.support + images) / place.num_overlap;
  return per_point * std::sqrt(static_cast<double>(place.num_overlap) / place.num_source);
}

bool IsConclusive(const AlignmentSystem& system) {
  return ComparesImages(system.num_photometric) &&
         system.intensity_correlation >= kConclusiveCorrelation &&
         system.num_inliers >= kConclusiveInlierRatio * system.num_overlap;
}

GaussNewtonState SearchStarts(const PyramidLevel& i,
                              CoarsePoints& j,
                              std::span<const Pose3> starts,
                              const StartSearch& search,
                              const AlignmentOptions& options) {
  const std::vector<GaussNewtonState> states = IterateFromAll(starts, search, i, j.some(), options);
  if (states.size() == 1) return states.front();
  std::vector<double> support;
  for (const GaussNewtonState& state : states)
    support.push_back(SupportAt(state.i_from_j, i, j.all(), options));
  return states[static_cast<std::size_t>(std::ranges::max_element(support) - support.begin())];
}

}  // namespace deepslam::alignment
