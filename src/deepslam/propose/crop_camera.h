// The camera of a network's crop: it stands where the view's camera stands, looks at the middle of
// what is shown, and is level.
//
// Where in a picture an object lies, and how the camera was held, says nothing of its shape;
// turning the camera takes both away. What a pixel shows is then found along one axis, and vertical
// things are vertical in the crop.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "deepslam/core/image.h"
#include "deepslam/core/quarter_turn.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/plane.h"

namespace deepslam::propose {

struct CropCamera {
  // Columns: right, down and forward of the crop's camera in the view's.
  Eigen::Matrix3d view_from_crop = Eigen::Matrix3d::Identity();
  // The square: its corner and its side, tangents of the crop's camera (pixels over focal length).
  double left = 0;
  double top = 0;
  double side = 0;

  // What lies at this place of the square, (0, 0) being its corner and (1, 1) the one across: the
  // direction in the view's camera that advances by 1 along the crop's axis.
  [[nodiscard]] Eigen::Vector3d RayAt(double x, double y) const {
    return view_from_crop * Eigen::Vector3d(left + x * side, top + y * side, 1);
  }
  // Of a point of the view's camera, along the crop's axis.
  [[nodiscard]] double DepthOf(const Eigen::Vector3d& p_view) const {
    return view_from_crop.col(2).dot(p_view);
  }
};

// The square is the silhouette's box in the crop's camera, made square and widened by a tenth.
// Level by the ground's normal, unless that is unknown or the camera looks nearly along it; then as
// the view's image stands when turned by `upright`. Nothing for an empty silhouette.
[[nodiscard]] std::optional<CropCamera> AimAt(const Mask& silhouette,
                                              const PinholeCamera& camera,
                                              const std::optional<Plane>& ground_camera,
                                              QuarterTurn upright);

// How far the crop's camera looks down, by the ground's normal; nothing when that is unknown.
[[nodiscard]] std::optional<double> ElevationOf(const CropCamera& crop,
                                                const std::optional<Plane>& ground_camera);

}  // namespace deepslam::propose
