// Gauss-Newton iterations on one level of two pyramids: robust weights and new correspondences in
// every step.
//
// Beyond the coarsest level each of the two terms, depth and intensity, counts by its independent
// measurements, and depth for its structure alone (degenerate_directions.h), so that intensity
// decides in the directions that depth leaves weak, and depth in those where it is strong.
#pragma once

#include <optional>
#include <span>

#include "deepslam/alignment/alignment_options.h"
#include "deepslam/alignment/alignment_system.h"
#include "deepslam/alignment/degenerate_directions.h"
#include "deepslam/alignment/source_points.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::alignment {

// Keeps directions that nothing constrains where the start put them.
inline constexpr StartSigma kPriorSigma;
// Distance at which the motion of points shows whether iterations have converged.
inline constexpr double kConvergedDistanceM = 2.0;
// At the coarsest level.
inline constexpr double kConvergedCoarsestPx = 0.04;

// Iterations from one start, through the levels.
struct GaussNewtonState {
  Pose3 i_from_j;
  Pose3 start_i_from_j;                   // a weak prior keeps unconstrained directions there
  AlignmentGates gates;                   // of the next step
  AlignmentSystem system;                 // at i_from_j, of the last level visited
  int stride = 1;                         // ... of every stride-th row and column
  DegenerateDirections fixed;             // no steps along these
  std::optional<StartSigma> fixed_sigma;  // how well the place along them is known, if measured
  // Converged when what is left to go moves points at kConvergedDistanceM by less.
  double converged_px = kConvergedCoarsestPx;
  std::optional<Matrix6d> structural;  // StructuralShare at the level's first step, for all of them
};

[[nodiscard]] GaussNewtonState StartAt(const Pose3& start_i_from_j);

// Gates of a level, `num_coarser` levels below the coarsest one that is aligned.
[[nodiscard]] AlignmentGates LevelGates(const AlignmentOptions& options, std::size_t num_coarser);

// Until converged, or options.max_iterations. False when the way leads to one of the poses `known`
// and was left there.
bool Iterate(const PyramidLevel& i,
             const SourcePoints& j,
             const AlignmentOptions& options,
             GaussNewtonState& state,
             std::span<const Pose3> known = {});

// Whether iterations from the two end at the same place.
[[nodiscard]] bool IsSamePlace(const Pose3& a, const Pose3& b);
[[nodiscard]] bool IsAmong(std::span<const Pose3> places, const Pose3& place);

// How many of a level's pixels share one error and count as one measurement: at least 1. The length
// over which errors are shared is one of a 640 pixel wide image; of the level every stride-th row
// and column is taken.
[[nodiscard]] double PixelsPerMeasurement(const PyramidLevel& level,
                                          int stride,
                                          double length_at_640_px);
[[nodiscard]] double PixelsPerMeasurement(const SourcePoints& points, double length_at_640_px);

// Anderson's mixing with a memory of one step: robust weights and new pairs make Gauss-Newton
// converge linearly, and by the last two steps it is seen where to.
class AndersonMixing {
 public:
  // The move to make instead of a step (a perturbation).
  [[nodiscard]] Vector6d Move(const Vector6d& step);

 private:
  bool is_under_way_ = false;
  Vector6d last_step_ = Vector6d::Zero();
  Vector6d last_move_ = Vector6d::Zero();
};

// What is left to go behind a step, as steps shrink by about the same share each time.
class ConvergenceEstimate {
 public:
  // In pixels, at kConvergedDistanceM; at most the step itself, and that before two are known.
  [[nodiscard]] double RemainingPx(const Vector6d& step, double focal_px);

 private:
  double last_px_ = 0;
};

}  // namespace deepslam::alignment
