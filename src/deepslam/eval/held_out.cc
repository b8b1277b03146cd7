#include "deepslam/eval/held_out.h"

#include <cmath>

#include "deepslam/core/check.h"
#include "deepslam/shape/rasterise_depth.h"

namespace deepslam::eval {

double HeldOutAgreement::agreement() const {
  return num_judged() > 0 ? static_cast<double>(num_agree) / static_cast<double>(num_judged()) : 0;
}

HeldOutAgreement& HeldOutAgreement::operator+=(const HeldOutAgreement& other) {
  num_agree += other.num_agree;
  num_violated += other.num_violated;
  num_hidden += other.num_hidden;
  return *this;
}

HeldOutAgreement ScoreHeldOut(const TriangleMesh& mesh,
                              const Pose3& camera_from_mesh,
                              const PinholeCamera& camera,
                              const DepthImage& depth_m) {
  DEEPSLAM_CHECK(depth_m.width() == camera.width && depth_m.height() == camera.height,
                 "depth and camera differ in size");
  const DepthImage model_m = shape::RasteriseDepth(mesh, camera_from_mesh, camera);
  HeldOutAgreement agreement;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const auto model = static_cast<double>(model_m(u, v));
      const auto measured = static_cast<double>(depth_m(u, v));
      if (!(model > 0) || !(measured > 0)) continue;
      if (std::abs(measured - model) <= kHeldOutToleranceM) {
        ++agreement.num_agree;
      } else if (measured > model) {
        ++agreement.num_violated;
      } else {
        ++agreement.num_hidden;
      }
    }
  }
  return agreement;
}

double MeasuredShare::share() const {
  return num_measured > 0 ? static_cast<double>(num_near) / static_cast<double>(num_measured) : 0;
}

MeasuredShare& MeasuredShare::operator+=(const MeasuredShare& other) {
  num_near += other.num_near;
  num_measured += other.num_measured;
  return *this;
}

MeasuredShare ScoreMeasured(const shape::ShapeModel& model,
                            const Similarity3& camera_from_object,
                            const PinholeCamera& camera,
                            const DepthImage& depth_m,
                            const Mask& mask) {
  DEEPSLAM_CHECK(depth_m.width() == camera.width && depth_m.height() == camera.height &&
                     mask.width() == camera.width && mask.height() == camera.height,
                 "depth, mask and camera differ in size");
  const SimilarityMatrix object_from_camera(camera_from_object.Inverse());
  MeasuredShare measured;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      if (mask(u, v) == 0 || !(depth_m(u, v) > 0)) continue;
      const Eigen::Vector3d point = object_from_camera * camera.Unproject(u, v, depth_m(u, v));
      const double distance_m =
          camera_from_object.scale * std::abs(model.Distance(point.cast<float>()));
      ++measured.num_measured;
      if (distance_m <= kHeldOutToleranceM) ++measured.num_near;
    }
  }
  return measured;
}

}  // namespace deepslam::eval
