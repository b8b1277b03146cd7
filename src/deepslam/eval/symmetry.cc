#include "deepslam/eval/symmetry.h"

#include <cmath>
#include <numbers>

#include "deepslam/shape/shape_model.h"

namespace deepslam::eval {
namespace {

constexpr double kNearVoxels = 1.5;
constexpr double kNearShare = 0.98;
constexpr int kStepDeg = 15;

bool StaysWhenTurned(const shape::ShapeModel& model, int angle_deg) {
  const float angle = static_cast<float>(angle_deg) * std::numbers::pi_v<float> / 180.0F;
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
         kNearShare * static_cast<double>(model.surface_points().size());
}

}  // namespace

Symmetry SymmetryOf(const VoxelGrid& grid) {
  const shape::ShapeModel model(grid);
  if (model.empty() || !StaysWhenTurned(model, 180)) return Symmetry::kNone;
  if (!StaysWhenTurned(model, 90)) return Symmetry::kHalf;
  for (int angle = kStepDeg; angle < 90; angle += kStepDeg) {
    if (!StaysWhenTurned(model, angle)) return Symmetry::kQuarter;
  }
  return Symmetry::kAny;
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

VoxelGrid Turned(const VoxelGrid& grid, int quarters) {
  VoxelGrid turned = grid;
  for (int n = ((quarters % 4) + 4) % 4; n > 0; --n) {
    const VoxelGrid from = turned;
    for (int i = 0; i < kGridSize; ++i) {
      for (int j = 0; j < kGridSize; ++j) {
        for (int k = 0; k < kGridSize; ++k) {
          turned.occupied[VoxelGrid::Index(kGridSize - 1 - j, i, k)] =
              from.occupied[VoxelGrid::Index(i, j, k)];
        }
      }
    }
  }
  return turned;
}

}  // namespace deepslam::eval
