// Which of a model's surface a camera can see, from a table of directions, thinned to about one
// point per patch.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "deepslam/shape/shape_model.h"
#include "deepslam/shape/solid_bits.h"

namespace deepslam::registration {

struct SurfacePoint {
  Eigen::Vector3f point = Eigen::Vector3f::Zero();   // object units
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // outward, unit
};

// Keeps the views it has made: one object per candidate and thread.
class VisibleSurface {
 public:
  // Edge of the cells of which one point is kept.
  static constexpr int kCellVoxels = 4;

  explicit VisibleSurface(const shape::ShapeModel& model) : model_(model) {}

  // Points visible from a camera in the given direction of the model's centre (object axes, any
  // length > 0); the direction is rounded to 15 degrees.
  const std::vector<SurfacePoint>& From(const Eigen::Vector3d& direction_object);

 private:
  void Prepare();

  const shape::ShapeModel& model_;
  // Of the model, made with the first view.
  std::shared_ptr<const shape::SolidBits> solid_;
  std::vector<std::uint16_t> cell_of_point_;
  std::map<std::pair<int, int>, std::vector<SurfacePoint>> views_;
};

}  // namespace deepslam::registration
