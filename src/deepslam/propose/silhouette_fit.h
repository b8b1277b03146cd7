// Places a model so that its outlines agree with an object's silhouettes: what colour alone tells.
//
// Nothing of the sensor's depth enters but the silhouettes' own origin (stage `segment`), the
// tracked poses and the ground.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "deepslam/geometry/pose.h"
#include "deepslam/propose/coarse_shape.h"
#include "deepslam/propose/fit_model.h"
#include "deepslam/scene/object_view.h"

namespace deepslam::propose {

// One view's silhouette on a raster of some dozen cells.
class SilhouetteView {
 public:
  // Gaps of the mask narrower than two cells are closed.
  SilhouetteView(const ObjectView& view, const Pose3& level_from_world);

  [[nodiscard]] bool empty() const { return num_inside_ == 0; }
  // In level coordinates: where the camera is, and the direction to the middle of the silhouette
  // moved by `offset` cells.
  [[nodiscard]] Eigen::Vector3d camera_level() const;
  [[nodiscard]] Eigen::Vector3d RayToMiddle(const Eigen::Vector2d& offset) const;
  // Raster coordinates (u, v) and depth; depth not above 0 when behind the camera.
  [[nodiscard]] Eigen::Vector3f Project(const Eigen::Vector3f& p_level) const;
  // Intersection over union of the silhouette and the points drawn `side_m` wide, inside the crop.
  // `drawn` is scratch.
  [[nodiscard]] double Overlap(std::span<const Eigen::Vector3f> points_level,
                               float side_m,
                               std::vector<std::uint8_t>& drawn) const;

 private:
  Eigen::Matrix3f rotation_;  // camera from level
  Eigen::Vector3f translation_;
  float fx_, fy_, cx_, cy_;  // of the raster
  int width_ = 0;
  int height_ = 0;
  std::vector<std::uint8_t> inside_;
  int num_inside_ = 0;
  Eigen::Vector2d middle_ = Eigen::Vector2d::Zero();  // of the silhouette's box, cells
};

struct SilhouetteFitOptions {
  double stretch_min = 0.7;  // as RetrievalOptions has them
  double stretch_max = 1.4;
  bool has_ground = true;  // else the model's height above z = 0 is sought as well
};

struct SilhouetteFit {
  Placement placement;
  double score = 0;
};

// Mean overlap over the views, less what a stretch away from `real_size_m` costs; [0, 1].
[[nodiscard]] double ScoreSilhouettes(const CoarseShape& shape,
                                      const Placement& placement,
                                      const Eigen::Vector3d& real_size_m,
                                      std::span<const SilhouetteView> views);

// The best placement found from a number of yaws: the position by the rays to the silhouettes, then
// steps along position, yaw and size as long as the score grows.
[[nodiscard]] SilhouetteFit FitSilhouettes(const CoarseShape& shape,
                                           const Eigen::Vector3d& real_size_m,
                                           std::span<const SilhouetteView> views,
                                           const SilhouetteFitOptions& options);

}  // namespace deepslam::propose
