// What an orthographic camera sees of a model: the partial views that start registration (paper,
// camera-to-model pose).
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>

#include <Eigen/Core>

#include "deepslam/shape/shape_model.h"
#include "deepslam/shape/solid_bits.h"

namespace deepslam::shape {

// The way from a model's surface to a camera far away, in steps through the model's voxels.
struct ViewRay {
  Eigen::Vector3f direction;  // to the camera
  Eigen::Vector3f step;       // voxels
  Eigen::Array3f per_step;    // 1 / step
  // Where the ray leaves the box of all that is solid, a little before and a little behind; voxels
  // from the grid's corner. Beyond, nothing can be in the way.
  Eigen::Array3f before_exit, behind_exit;

  // 0 where `exit` is behind already.
  [[nodiscard]] int StepsTo(const Eigen::Array3f& exit, const Eigen::Vector3f& at) const {
    constexpr float kMaxSteps = 4 * kGridSize;  // more than through the grid's diagonal
    const float steps = ((exit - at.array()) * per_step).minCoeff();
    return static_cast<int>(std::clamp(steps, 0.0F, kMaxSteps));
  }
};

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
  ViewRay ray_;
};

}  // namespace deepslam::shape
