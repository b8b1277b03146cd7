#include "deepslam/alignment/degenerate_directions.h"

#include <cmath>

#include <Eigen/Eigenvalues>

namespace deepslam::alignment {
namespace {

// Share of the strongest direction's information below which depth leaves a direction to images.
constexpr double kWeakRatio = 0.02;
// Depth leaves no more than three directions free: a plane does.
constexpr int kMaxWeakDirections = 3;
// Normals are off by about 0.1 rad (rms), and the squares of that look like structure: in every
// direction this share of the strongest one's information is theirs.
constexpr double kNoiseOfNormals = 0.01;

std::optional<Vector6d> ArcScale(const Matrix6d& hessian) {
  const double translation = hessian.topLeftCorner<3, 3>().trace();
  const double rotation = hessian.bottomRightCorner<3, 3>().trace();
  if (!(translation > 0) || !(rotation > 0)) return std::nullopt;
  Vector6d scale = Vector6d::Ones();
  scale.tail<3>().setConstant(std::sqrt(rotation / translation));
  return scale;
}

}  // namespace

std::optional<DirectionSpectrum> SpectrumByArc(const Matrix6d& hessian) {
  const std::optional<Vector6d> scale = ArcScale(hessian);
  if (!scale) return std::nullopt;
  const Eigen::DiagonalMatrix<double, 6> by_arc(scale->cwiseInverse());
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(by_arc * hessian * by_arc);
  return DirectionSpectrum{*scale, eigen.eigenvalues(), eigen.eigenvectors()};
}

DegenerateDirections::DegenerateDirections(const Matrix6d& hessian)
    : spectrum_(SpectrumByArc(hessian)) {
  if (!spectrum_) return;
  while (num_ < 6 && spectrum_->values[num_] < kUnconstrainedRatio * spectrum_->values[5]) ++num_;
}

std::vector<Vector6d> DegenerateDirections::Directions() const {
  std::vector<Vector6d> directions;
  for (int k = 0; k < num_; ++k)
    directions.push_back(spectrum_->Perturbation(spectrum_->directions.col(k)));
  return directions;
}

Vector6d DegenerateDirections::Component(const Vector6d& motion) const {
  if (empty()) return Vector6d::Zero();
  const auto basis = spectrum_->directions.leftCols(num_);
  const Vector6d motion_m = spectrum_->scale.cwiseProduct(motion);
  return spectrum_->Perturbation(basis * (basis.transpose() * motion_m));
}

std::vector<Vector6d> WeakDirections(const Matrix6d& depth_hessian) {
  const std::optional<DirectionSpectrum> spectrum = SpectrumByArc(depth_hessian);
  if (!spectrum) return {};
  std::vector<Vector6d> weak;
  const double least = kWeakRatio * spectrum->values[5];
  for (int k = 0; k < kMaxWeakDirections && spectrum->values[k] < least; ++k)
    weak.push_back(spectrum->Perturbation(spectrum->directions.col(k)));
  return weak;
}

Matrix6d StructuralShare(const Matrix6d& depth_hessian) {
  const std::optional<DirectionSpectrum> spectrum = SpectrumByArc(depth_hessian);
  if (!spectrum) return Matrix6d::Identity();
  const double noise = kNoiseOfNormals * spectrum->values[5];
  const Vector6d values = spectrum->values.cwiseMax(0.0);
  const Vector6d share = values.array() / (values.array() + noise);
  const Matrix6d& directions = spectrum->directions;
  return spectrum->scale.asDiagonal() * directions * share.asDiagonal() * directions.transpose() *
         spectrum->scale.cwiseInverse().asDiagonal();
}

}  // namespace deepslam::alignment
