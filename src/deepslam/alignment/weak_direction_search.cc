#include "deepslam/alignment/weak_direction_search.h"

#include <algorithm>
#include <cmath>

namespace deepslam::alignment {
namespace {

// Steps along a weak direction, pixels of the coarsest level, to each side.
constexpr double kStepPx = 0.75;
constexpr int kNumSteps = 10;  // 7.5 px to each side: an eighth of a level that is 60 wide
// Images share no more than this of their variance, the camera's noise being what it is.
constexpr double kFullCorrelation = 0.999;

double MeanDepthM(const PyramidLevel& level) {
  double sum = 0;
  int count = 0;
  for (const float z : level.depth_m) {
    if (!(z > 0)) continue;
    sum += static_cast<double>(z);
    ++count;
  }
  return count > 0 ? sum / count : 1.0;
}

// Information per pixel that the two images share, nats: that of jointly normal variables. Where
// one contrast outweighs all (a light wall over a dark floor), the correlation itself is near 1
// wherever the frames lie along it.
double SharedInformation(const PlaceScore& place) {
  if (!ComparesImages(place.num_photometric)) return 0;
  const double correlation = std::clamp(place.intensity_correlation, 0.0, kFullCorrelation);
  return -0.5 * std::log(1 - correlation * correlation);
}

// What places along a weak direction are compared by: the common points alone, since how many there
// are is least where the camera moved most.
struct Agreement {
  double value = 0;       // of geometry and images, per point
  double resolution = 0;  // differences below this are chance
};

Agreement AgreementAt(const PyramidLevel& i,
                      const SourcePoints& j,
                      const Pose3& i_from_j,
                      const AlignmentOptions& options) {
  const PlaceScore place = ScoreCoarsely(i, j, i_from_j, options);
  if (place.num_overlap == 0) return {};
  const double independent =
      place.num_photometric / PixelsPerMeasurement(j, options.photometric_correlation_length_px);
  return {place.support / place.num_overlap + SharedInformation(place),
          kSureNats / std::max(1.0, independent)};
}

// Of steps to both sides the one that is surely more like than none; 0 where none is. Every second
// one is looked at, and those between where the score might rise to the best one as steeply as
// it falls from none.
template <typename ScoreOfStep>
int BestStep(const ScoreOfStep& score_of) {
  const Agreement here = score_of(0);
  const double before = score_of(-1).value, behind = score_of(1).value;
  const double rise = std::max(0.0, here.value - std::min(before, behind));
  int best = 0;
  double best_value = here.value + here.resolution;
  const auto take = [&](int n, double value) {
    if (value <= best_value) return;
    best = n;
    best_value = value;
  };
  take(-1, before);
  take(1, behind);
  for (const int side : {-1, 1}) {
    double last = side < 0 ? before : behind;
    for (int n = 2; n <= kNumSteps; n += 2) {
      const double value = score_of(side * n).value;
      take(side * n, value);
      const bool skipped = n > 2;
      if (skipped && std::max(last, value) + rise > best_value)
        take(side * (n - 1), score_of(side * (n - 1)).value);
      last = value;
    }
  }
  return best;
}

}  // namespace

double SharedInformation(const PyramidLevel& i,
                         const SourcePoints& j,
                         const Pose3& i_from_j,
                         const AlignmentOptions& options) {
  const PlaceScore place = ScoreCoarsely(i, j, i_from_j, options);
  return place.num_photometric /
         PixelsPerMeasurement(j, options.photometric_correlation_length_px) *
         SharedInformation(place);
}

GaussNewtonState SearchWeakDirections(const PyramidLevel& i,
                                      CoarsePoints& j,
                                      const AlignmentOptions& options,
                                      const GaussNewtonState& state) {
  GaussNewtonState best = state;
  for (const Vector6d& direction :
       WeakDirections(state.system.hessian - state.system.photometric_hessian)) {
    const double step_m = kStepPx * MeanDepthM(j.level()) / j.level().camera.fx;
    const GaussNewtonState centre = best;
    GaussNewtonState tried = centre;
    const auto place_at = [&](int n) { return V2t(n * step_m * direction) * centre.i_from_j; };
    const int best_step = BestStep([&](int n) {
      return AgreementAt(i, j.some(), n == 0 ? centre.i_from_j : place_at(n), options);
    });
    if (best_step == 0) continue;
    tried.i_from_j = place_at(best_step);
    if (IsSamePlace(tried.i_from_j, centre.i_from_j)) continue;
    tried.start_i_from_j = tried.i_from_j;
    Iterate(i, j.all(), options, tried);
    const Agreement before = AgreementAt(i, j.all(), centre.i_from_j, options);
    const Agreement after = AgreementAt(i, j.all(), tried.i_from_j, options);
    if (after.value > before.value + before.resolution) best = tried;
  }
  return best;
}

}  // namespace deepslam::alignment
