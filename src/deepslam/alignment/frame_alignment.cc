#include "deepslam/alignment/frame_alignment.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "deepslam/alignment/edge_information.h"
#include "deepslam/alignment/reference_pixels.h"
#include "deepslam/alignment/solution_remapping.h"
#include "deepslam/alignment/weak_direction_search.h"
#include "deepslam/core/check.h"

namespace deepslam::alignment {
namespace {

// Scale of the first step where the start is near, standard deviations of the noise and grey
// levels: within a few pixels of the levels that are left.
constexpr float kNearScale = 6.0F;
constexpr float kNearPhotometricScale = 12.0F;  // grey levels
constexpr std::size_t kNearLevels = 2;          // finest ones, gone through from there
// Of the finest level: when iterations end, and by every how many batches of points their end is
// measured.
struct FinestEnd {
  double converged_px;
  int batch_stride;
};
// Of what becomes an edge.
constexpr FinestEnd kMeasured{0.01, 1};
// Where a frame is only to be placed: ends lie towards the start, which edges would carry on.
constexpr FinestEnd kPlaced{0.05, 2};
constexpr double kConvergedMiddlePx = 0.08;  // at levels that a finer one follows
// Depth errors are shared between neighbouring pixels (see `correlation_length_px`): at a finest
// level of this width nothing is lost by taking every third row and column, and little at levels of
// that width that a finer one follows.
constexpr int kWideStride = 3;
constexpr int kWideLevel = 240;        // px
constexpr int kWideMiddleLevel = 120;  // px
// Images that are as like as this are of the same place; then depth may be this much worse than
// asked, since the sensor's noise is known roughly only.
constexpr double kLikeImages = 0.9;
constexpr double kInlierRatioOfLikeImages = 0.6;  // of the ratio that is asked

int FinestStride(const PyramidLevel& level) {
  return level.camera.width >= kWideLevel ? kWideStride : 1;
}

int MiddleStride(const PyramidLevel& level) {
  return level.camera.width >= kWideMiddleLevel ? kWideStride : 1;
}

SourcePoints NearPoints(const PyramidLevel& level, int stride, const AlignmentOptions& options) {
  return SourcePoints(level, {stride, options.photometric, true});
}

// Of a level that `num_coarser` others precede; scales open again for what the level adds.
void TakeGates(const AlignmentOptions& options, std::size_t num_coarser, GaussNewtonState& state) {
  AlignmentGates gates = LevelGates(options, num_coarser);
  gates.systematic_m = state.gates.systematic_m;
  gates.geometric_scale = 2 * state.gates.geometric_scale;
  gates.photometric_scale = 2 * state.gates.photometric_scale;
  gates.gain = state.gates.gain;
  gates.bias = state.gates.bias;
  gates.falloff = state.gates.falloff;
  state.gates = gates;
}

struct FramePair {
  const FramePyramid& i;
  const FramePyramid& j;
  const AlignmentOptions& options;
};

// Down the `num_levels` finest levels, and measured at the end.
void IterateToFinest(const FramePair& pair,
                     std::size_t num_levels,
                     const FirstStart& first_start,
                     const FinestEnd& end,
                     GaussNewtonState& state) {
  const AlignmentOptions& options = pair.options;
  const std::size_t coarsest = NumAlignmentLevels(pair.i) - 1;
  for (std::size_t level = num_levels; level-- > 1;) {
    TakeGates(options, coarsest - level, state);
    state.converged_px = kConvergedMiddlePx;
    const PyramidLevel& source = pair.j.levels[level];
    const SourcePoints points = NearPoints(source, MiddleStride(source), options);
    Iterate(pair.i.levels[level], points, options, state);
  }
  const PyramidLevel& source = pair.j.levels.front();
  const SourcePoints points = num_levels > 0 ? NearPoints(source, FinestStride(source), options)
                                             : FarPoints(source, 1, options);
  const FinestLevel finest{
      pair.i, pair.j, pair.i.levels.front(), points, end.batch_stride, options};
  if (num_levels > 0) {
    TakeGates(options, coarsest, state);
    state.converged_px = end.converged_px;
    Iterate(finest.i, points, options, state);
  }
  MeasureEnd(finest, state);
  state = Remapped(finest, first_start, state);
}

bool IsOk(const FrameAlignment& alignment, bool has_colour, const AlignmentOptions& options) {
  const bool like = has_colour && alignment.intensity_correlation >= kLikeImages;
  const double min_inlier_ratio = (like ? kInlierRatioOfLikeImages : 1) * options.min_inlier_ratio;
  return alignment.overlap_ratio >= options.min_overlap &&
         alignment.inlier_ratio >= min_inlier_ratio &&
         alignment.intensity_correlation >= options.min_intensity_correlation;
}

FrameAlignment Conclude(const GaussNewtonState& state,
                        const PyramidLevel& finest,
                        const StartSigma& start_sigma,
                        const AlignmentOptions& options) {
  const AlignmentSystem& system = state.system;
  FrameAlignment result;
  result.i_from_j = state.i_from_j;
  const EdgeInformation edge = EdgeInformationOf(state, finest, start_sigma, options);
  result.information = edge.information;
  const double num_source = std::max(1, system.num_source);
  result.rmse_m =
      system.num_inliers > 0 ? std::sqrt(system.sum_squared_m2 / system.num_inliers) : 0;
  result.fitness = system.num_inliers / num_source;
  result.overlap_ratio = system.num_overlap / num_source;
  result.inside_ratio = system.num_inside / num_source;
  result.constraint_ratio = edge.constraint_ratio;
  result.remapped = !state.fixed.empty() && !state.fixed_sigma;
  result.degenerate = result.remapped || edge.constraint_ratio < AlignmentOptions::kDegenerateRatio;
  result.inlier_ratio = static_cast<double>(system.num_inliers) / std::max(1, system.num_overlap);
  const bool has_colour = ComparesImages(system.num_photometric);
  if (has_colour) result.intensity_correlation = system.intensity_correlation;
  result.ok = IsOk(result, has_colour, options);
  return result;
}

bool Comparable(const FramePyramid& i, const FramePyramid& j) {
  return !i.empty() && i.levels.size() == j.levels.size();
}

FrameAlignment Failed(const Pose3& i_from_j) {
  FrameAlignment failed;
  failed.i_from_j = i_from_j;
  return failed;
}

AlignmentOptions WithNoiseOf(const FramePyramid& i,
                             const FramePyramid& j,
                             const AlignmentOptions& user_options) {
  AlignmentOptions options = user_options;
  options.pyramid.noise = options.pyramid.noise.Scaled(std::max(i.noise_scale, j.noise_scale));
  return options;
}

}  // namespace

FrameAlignment AlignPyramids(const FramePyramid& i,
                             const FramePyramid& j,
                             std::span<const Pose3> initial_i_from_j,
                             const AlignmentOptions& user_options,
                             const StartSigma& start_sigma,
                             const StartSearch& search) {
  DEEPSLAM_CHECK(!initial_i_from_j.empty(), "alignment needs a start");
  if (!Comparable(i, j)) return Failed(initial_i_from_j.front());
  DEEPSLAM_CHECK(IsReference(i), "frames are aligned to references");
  const AlignmentOptions options = WithNoiseOf(i, j, user_options);
  const std::size_t coarsest = NumAlignmentLevels(i) - 1;
  const PyramidLevel& coarsest_i = i.levels[coarsest];
  CoarsePoints coarsest_j(j.levels[coarsest], options);
  GaussNewtonState state = SearchStarts(coarsest_i, coarsest_j, initial_i_from_j, search, options);
  if (options.photometric && !IsConclusive(state.system))
    state = SearchWeakDirections(coarsest_i, coarsest_j, options, state);
  IterateToFinest(
      {i, j, options}, coarsest, {initial_i_from_j.front(), start_sigma, false}, kPlaced, state);
  return Conclude(state, j.levels.front(), start_sigma, options);
}

FrameAlignment RefineAlignment(const FramePyramid& i,
                               const FramePyramid& j,
                               const Pose3& i_from_j,
                               const AlignmentOptions& user_options) {
  if (!Comparable(i, j)) return Failed(i_from_j);
  DEEPSLAM_CHECK(IsReference(i), "frames are aligned to references");
  const AlignmentOptions options = WithNoiseOf(i, j, user_options);
  GaussNewtonState state = StartAt(i_from_j);
  state.gates.systematic_m = 0;  // the place is known: what moves with the camera fits nowhere
  state.gates.geometric_scale = kNearScale;
  state.gates.photometric_scale = kNearPhotometricScale;
  const std::size_t num_levels = std::min(kNearLevels, NumAlignmentLevels(i));
  IterateToFinest({i, j, options}, num_levels, {i_from_j, {}, true}, kMeasured, state);
  return Conclude(state, j.levels.front(), {}, options);
}

FrameAlignment Sharpened(const FrameAlignment& found,
                         const FramePyramid& i,
                         const FramePyramid& j,
                         const AlignmentOptions& options) {
  if (!found.ok || found.remapped) return found;
  const FrameAlignment sharpened = RefineAlignment(i, j, found.i_from_j, options);
  return sharpened.ok ? sharpened : found;
}

}  // namespace deepslam::alignment
