#include "deepslam/modelling/long_side.h"

#include <numbers>
#include <optional>

#include <Eigen/Geometry>

#include "deepslam/shape/stretch.h"

namespace deepslam::modelling {
namespace {

// Of 29 tables of the catalogues 23 are longer along y by more than a tenth, one along x.
constexpr double kLonger = 1.1;

}  // namespace

void FaceAcrossLongSide(refine::CompletedModel& model) {
  const std::optional<VoxelBox> box = OccupiedBox(model.grid);
  if (!box || box->sides().x() <= kLonger * box->sides().y()) return;
  const Eigen::Quaterniond back(
      Eigen::AngleAxisd(-0.5 * std::numbers::pi, Eigen::Vector3d::UnitZ()));
  model.grid = shape::TurnGrid(model.grid, 1);
  model.model_from_grid = model.model_from_grid * Similarity3{1.0, back};
}

}  // namespace deepslam::modelling
