// How alike the fine texture of two images is where depth lays the one on the other.
#pragma once

#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/core/unfilled.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"

namespace deepslam {

// Intensities behind local contrast normalisation (local_contrast.h): those of image i as they are,
// those of j at points in its camera.
class TextureMatch {
 public:
  struct View {
    const PinholeCamera& camera;
    const Image<float>& intensity;
  };
  struct Comparison {
    double num_points = 0;   // that fall into the other image
    double correlation = 0;  // zero-mean, normalised
  };

  // Points of every stride-th row and column that have depth; images of the cameras' sizes.
  TextureMatch(const View& i, const View& j, const UnfilledVector<float>& depth_j_m, int stride);

  [[nodiscard]] const PinholeCamera& camera() const { return camera_; }
  [[nodiscard]] double mean_depth_m() const { return mean_depth_m_; }
  // Of the points' angles with the optical axis, root mean square.
  [[nodiscard]] double rms_tangent() const { return rms_tangent_; }

  // Nothing where less than 30 % of the points fall into image i.
  [[nodiscard]] Comparison Compare(const Pose3& i_from_j) const {
    return Compare(i_from_j, kAllPatches);
  }
  // Of 4 x 4 patches, those of them that fall into image i, the share that correlates by 0.3.
  [[nodiscard]] double ShareOfPatches(const Pose3& i_from_j) const;
  // Between the images of the points, root mean square.
  [[nodiscard]] double DistancePx(const Pose3& one_i_from_j, const Pose3& other_i_from_j) const;

 private:
  static constexpr int kAllPatches = -1;  // instead of the number of one
  struct Point {
    float x, y, z, value;
    int patch;
  };
  [[nodiscard]] Comparison Compare(const Pose3& i_from_j, int patch) const;

  PinholeCamera camera_;
  Image<float> image_;
  std::vector<Point> points_;
  double mean_depth_m_ = 1;
  double rms_tangent_ = 1;
};

}  // namespace deepslam
