// What an orthographic camera sees of a model: the partial views that start registration (paper,
// camera-to-model pose).
#pragma once

#include <cstddef>
#include <memory>

#include <Eigen/Core>

#include "deepslam/shape/shape_model.h"
#include "deepslam/shape/solid_bits.h"

namespace deepslam::shape {

// A camera infinitely far away in direction (cos e cos a, cos e sin a, sin e) of a model, looking
// at its centre; a = azimuth about z, 0 = in front (+x), e = elevation above the horizon.
class PartialView {
 public:
  // Keeps a reference to the model.
  explicit PartialView(const ShapeModel& model, double azimuth_rad, double elevation_rad = 0);
  // For many views of one model: `solid` is its grid.
  PartialView(const ShapeModel& model,
              std::shared_ptr<const SolidBits> solid,
              double azimuth_rad,
              double elevation_rad);

  // Whether the n-th of the model's surface points (ShapeModel::surface_points) is visible: a ray
  // through the voxels, so ask only of points that matter.
  [[nodiscard]] bool Shows(std::size_t n) const;

 private:
  const ShapeModel& model_;
  std::shared_ptr<const SolidBits> solid_;
  Eigen::Vector3f direction_;  // to the camera
};

}  // namespace deepslam::shape
