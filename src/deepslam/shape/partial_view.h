// What an orthographic camera sees of a model: the partial views that start registration (paper,
// camera-to-model pose).
#pragma once

#include <vector>

#include <Eigen/Core>

#include "deepslam/shape/shape_model.h"

namespace deepslam::shape {

// Surface points (see ShapeModel::surface_points) that are visible from a camera infinitely far
// away in direction (cos e cos a, cos e sin a, sin e) of the model, looking at its centre; a =
// azimuth about z, 0 = in front (+x), e = elevation above the horizon. In the order of the model's
// surface points.
[[nodiscard]] std::vector<Eigen::Vector3f> PartialView(const ShapeModel& model,
                                                       double azimuth_rad,
                                                       double elevation_rad = 0);

}  // namespace deepslam::shape
