// A flat part's colours, painted once, at halving resolutions so that distant pixels see means and
// not noise.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "deepslam/core/image.h"
#include "deepslam/synth/world.h"

namespace deepslam::synth {

class PaintedPart {
 public:
  // `part` must outlive it.
  PaintedPart(const RoomPart& part, const SceneDescription& scene);

  // Linear reflectance; `footprint_m`: what a pixel covers there.
  [[nodiscard]] Eigen::Vector3f At(const Eigen::Vector3d& p_world, double footprint_m) const;

 private:
  const RoomPart* part_;
  double pixel_m_ = 0;
  std::vector<Image<Eigen::Vector3f>> levels_;
};

}  // namespace deepslam::synth
