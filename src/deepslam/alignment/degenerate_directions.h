// What a Hessian says of single directions of a motion: which of them the measurements constrain
// well, weakly, or not at all.
//
// Hessians are of a left perturbation exp(d) i_from_j in frame i, order (translation m; rotation
// rad). Rotations count by their arc at the mean distance, so that all six directions are metres.
#pragma once

#include <optional>
#include <vector>

#include "deepslam/geometry/pose.h"

namespace deepslam::alignment {

// Share of the strongest direction's information below which depth alone does not constrain a
// direction at all (rendered rooms, frame to frame: 8 cm off below 0.002, 0.1 cm above 0.004). On a
// bare wall what looks like structure are the steps of the sensor's disparity, which stay with the
// camera as it moves.
inline constexpr double kUnconstrainedRatio = 0.003;

// A Hessian of a perturbation in metres.
struct DirectionSpectrum {
  Vector6d scale;       // what turns a perturbation into metres
  Vector6d values;      // ascending
  Matrix6d directions;  // unit vectors in metres, one column for each value

  // Back from metres.
  [[nodiscard]] Vector6d Perturbation(const Vector6d& motion_m) const {
    return scale.cwiseInverse().cwiseProduct(motion_m);
  }
};

// Nothing where the Hessian says nothing of translation or of rotation.
[[nodiscard]] std::optional<DirectionSpectrum> SpectrumByArc(const Matrix6d& hessian);

// The directions that depth alone does not constrain at all (kUnconstrainedRatio).
class DegenerateDirections {
 public:
  DegenerateDirections() = default;
  explicit DegenerateDirections(const Matrix6d& hessian);

  [[nodiscard]] bool empty() const { return num_ == 0; }
  // Perturbations of one metre.
  [[nodiscard]] std::vector<Vector6d> Directions() const;
  // The part of a perturbation that lies along them.
  [[nodiscard]] Vector6d Component(const Vector6d& motion) const;

 private:
  std::optional<DirectionSpectrum> spectrum_;
  int num_ = 0;
};

// Directions that depth constrains weakly, weakest first, three at most (along a wall, round the
// vertical on a floor): perturbations of one metre.
[[nodiscard]] std::vector<Vector6d> WeakDirections(const Matrix6d& depth_hessian);

// Of a direction's information, what depth shows and what the noise of its normals does not: the
// Hessian and its gradient are to be multiplied by it from the left. Identity where the Hessian
// says nothing.
[[nodiscard]] Matrix6d StructuralShare(const Matrix6d& depth_hessian);

}  // namespace deepslam::alignment
