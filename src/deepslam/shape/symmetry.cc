#include "deepslam/shape/symmetry.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "deepslam/core/angles.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::shape {
namespace {

constexpr double kNearVoxels = 1.5;     // voxels of two surfaces that are one differ by this
constexpr double kStayingShare = 0.98;  // of the surface; the rest may be noise
constexpr int kStepDeg = 15;            // a shape that stays at each of these turns is round

// Calls use(distance) with the distance from the surface, object units, of each of its points when
// turned.
template <typename Use>
void ForTurnedSurface(const ShapeModel& model, int angle_deg, const Use& use) {
  const auto angle = static_cast<float>(angle_deg * kRadPerDeg);
  const float c = std::cos(angle);
  const float s = std::sin(angle);
  // The axis is the middle of the model's box, which is the cube's.
  for (const Eigen::Vector3f& p : model.surface_points()) {
    const Eigen::Vector3f turned(c * p.x() - s * p.y(), s * p.x() + c * p.y(), p.z());
    use(std::abs(model.Distance(turned)));
  }
}

bool StaysWhenTurned(const ShapeModel& model, int angle_deg) {
  std::size_t near = 0;
  ForTurnedSurface(model, angle_deg, [&](float distance) {
    near += distance <= static_cast<float>(kNearVoxels * kVoxelSize) ? 1 : 0;
  });
  return static_cast<double>(near) >=
         kStayingShare * static_cast<double>(model.surface_points().size());
}

}  // namespace

Symmetry SymmetryOf(const ShapeModel& model) {
  if (model.empty() || !StaysWhenTurned(model, 180)) return Symmetry::kNone;
  if (!StaysWhenTurned(model, 90)) return Symmetry::kHalf;
  for (int angle = kStepDeg; angle < 90; angle += kStepDeg) {
    if (!StaysWhenTurned(model, angle)) return Symmetry::kQuarter;
  }
  return Symmetry::kAny;
}

Symmetry SymmetryOf(const VoxelGrid& grid) { return SymmetryOf(ShapeModel(grid)); }

bool IsRound(const ShapeModel& model, double scale_m, double max_mean_m) {
  if (model.empty()) return false;
  for (int angle = kStepDeg; angle < 360; angle += kStepDeg) {
    double sum = 0;
    ForTurnedSurface(model, angle, [&](float distance) { sum += distance; });
    const double mean_m = scale_m * sum / static_cast<double>(model.surface_points().size());
    if (!(mean_m <= max_mean_m)) return false;
  }
  return true;
}

std::vector<int> QuarterTurns(Symmetry symmetry) {
  switch (symmetry) {
    case Symmetry::kNone:
      return {0};
    case Symmetry::kHalf:
      return {0, 2};
    case Symmetry::kQuarter:
    case Symmetry::kAny:
      break;
  }
  return {0, 1, 2, 3};
}

double RotationApart(const Eigen::Quaterniond& a_from_b, Symmetry symmetry) {
  if (symmetry == Symmetry::kAny) {
    return std::acos(std::clamp((a_from_b * Eigen::Vector3d::UnitZ()).z(), -1.0, 1.0));
  }
  double least = std::numbers::pi;
  for (const int quarters : QuarterTurns(symmetry)) {
    const Eigen::AngleAxisd turn(quarters * std::numbers::pi / 2, Eigen::Vector3d::UnitZ());
    least = std::min(least, RotationAngle((turn * a_from_b).normalized()));
  }
  return least;
}

}  // namespace deepslam::shape
