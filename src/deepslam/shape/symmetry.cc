#include "deepslam/shape/symmetry.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "deepslam/core/angles.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::shape {
namespace {

constexpr double kNearVoxels = 1.5;  // voxels of two surfaces that are one differ by this
constexpr double kStayingShare = 0.98;  // of the surface; the rest may be noise
constexpr int kStepDeg = 15;         // a shape that stays at each of these turns is round

bool StaysWhenTurned(const ShapeModel& model, int angle_deg) {
  const auto angle = static_cast<float>(angle_deg * kRadPerDeg);
  const float c = std::cos(angle);
  const float s = std::sin(angle);
  // The axis is the middle of the model's box, which is the cube's.
  std::size_t near = 0;
  for (const Eigen::Vector3f& p : model.surface_points()) {
    const Eigen::Vector3f turned(c * p.x() - s * p.y(), s * p.x() + c * p.y(), p.z());
    near +=
        std::abs(model.Distance(turned)) <= static_cast<float>(kNearVoxels * kVoxelSize) ? 1 : 0;
  }
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
