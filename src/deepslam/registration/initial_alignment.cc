#include "deepslam/registration/initial_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "deepslam/core/wide_vectors.h"

namespace deepslam::registration {
namespace {

constexpr double kKeptShare = 0.8;
constexpr std::size_t kMaxPointsCompared = 150;

using Points = std::vector<Eigen::Vector3d>;

struct Moments {
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  double spread = 0;  // rms distance from the centroid
};

Moments MomentsOf(const Points& points) {
  Moments moments;
  for (const Eigen::Vector3d& point : points) moments.centroid += point;
  moments.centroid /= static_cast<double>(points.size());
  for (const Eigen::Vector3d& point : points) {
    moments.spread += (point - moments.centroid).squaredNorm();
  }
  moments.spread = std::sqrt(moments.spread / static_cast<double>(points.size()));
  return moments;
}

Points MeasuredPoints(const MeasuredView& view) {
  Points points;
  const std::size_t stride = view.points_camera.size() / kMaxPointsCompared + 1;
  for (std::size_t i = 0; i < view.points_camera.size(); i += stride) {
    points.push_back(view.points_camera[i].cast<double>());
  }
  return points;
}

// Coordinates side by side, filled up to whole lanes by points that are near to nothing.
class PointColumns {
 public:
  static constexpr std::size_t kLanes = 8;
  explicit PointColumns(const Points& points) {
    for (std::vector<float>& column : columns_)
      column.assign((points.size() + kLanes - 1) / kLanes * kLanes, kFar);
    for (std::size_t n = 0; n < points.size(); ++n) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        columns_[axis][n] = static_cast<float>(points[n][static_cast<Eigen::Index>(axis)]);
    }
  }
  [[nodiscard]] std::size_t size() const { return columns_[0].size(); }
  [[nodiscard]] const float* data(std::size_t axis) const { return columns_[axis].data(); }

 private:
  static constexpr float kFar = 1e6F;
  std::array<std::vector<float>, 3> columns_;
};

// Squared distances of the first points of `from`, as many as `squares` holds, to their nearest
// ones of `to`.
DEEPSLAM_WIDE_VECTORS void NearestSquares(const PointColumns& from,
                                          const PointColumns& to,
                                          std::vector<float>& squares) {
  constexpr std::size_t kLanes = PointColumns::kLanes;
  const float* const x = to.data(0);
  const float* const y = to.data(1);
  const float* const z = to.data(2);
  for (std::size_t n = 0; n < squares.size(); ++n) {
    const float px = from.data(0)[n], py = from.data(1)[n], pz = from.data(2)[n];
    std::array<float, kLanes> nearest;
    nearest.fill(std::numeric_limits<float>::infinity());
    for (std::size_t k = 0; k < to.size(); k += kLanes) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const float dx = x[k + lane] - px, dy = y[k + lane] - py, dz = z[k + lane] - pz;
        const float square = dx * dx + dy * dy + dz * dz;
        nearest[lane] = square < nearest[lane] ? square : nearest[lane];
      }
    }
    squares[n] = *std::min_element(nearest.begin(), nearest.end());
  }
}

// Sum of the kept (smallest) squared distances to the nearest neighbour, and how many.
std::pair<double, double> TrimmedSquares(const Points& from, const Points& to) {
  std::vector<float> squares(from.size());
  NearestSquares(PointColumns(from), PointColumns(to), squares);
  std::sort(squares.begin(), squares.end());
  const auto kept =
      static_cast<std::size_t>(std::ceil(kKeptShare * static_cast<double>(squares.size())));
  double sum = 0;
  for (std::size_t i = 0; i < kept; ++i) sum += static_cast<double>(squares[i]);
  return {sum, static_cast<double>(kept)};
}

double PointToPointError(const Points& measured, const Points& model) {
  const auto [forward, num_forward] = TrimmedSquares(measured, model);
  const auto [backward, num_backward] = TrimmedSquares(model, measured);
  return std::sqrt(0.5 * (forward / num_forward + backward / num_backward));
}

// Rotation that takes the model's z to `up` and its direction at `azimuth_rad` to `towards_camera`,
// both of the camera frame and perpendicular to each other.
Eigen::Quaterniond UprightRotation(const Eigen::Vector3d& up,
                                   const Eigen::Vector3d& towards_camera,
                                   double azimuth_rad) {
  Eigen::Matrix3d camera_from_facing;  // facing frame: x towards the camera, z up
  camera_from_facing << towards_camera, up.cross(towards_camera), up;
  const Eigen::AngleAxisd facing_from_object(-azimuth_rad, Eigen::Vector3d::UnitZ());
  return Eigen::Quaterniond(camera_from_facing) * facing_from_object;
}

}  // namespace

std::vector<InitialAlignment> AlignByMoments(VisibleSurface& visible,
                                             const MeasuredView& view,
                                             int num_azimuths,
                                             double min_scale_m,
                                             double max_scale_m) {
  const Points measured = MeasuredPoints(view);
  if (measured.size() < 3) return {};
  const Moments seen = MomentsOf(measured);
  const Eigen::Vector3d to_camera = -seen.centroid;
  const double rise = to_camera.dot(view.up_camera);
  const Eigen::Vector3d level = to_camera - rise * view.up_camera;
  if (!(seen.spread > 1e-6) || !(level.norm() > 1e-6)) return {};
  const std::array<double, 2> elevations_rad = {0.0, std::atan2(rise, level.norm())};
  std::vector<InitialAlignment> alignments;
  for (const double elevation : elevations_rad) {
    for (int k = 0; k < num_azimuths; ++k) {
      const double azimuth = 2 * std::numbers::pi * k / num_azimuths;
      Points model;
      for (const SurfacePoint& surface : visible.From({std::cos(elevation) * std::cos(azimuth),
                                                       std::cos(elevation) * std::sin(azimuth),
                                                       std::sin(elevation)})) {
        model.push_back(surface.point);
      }
      if (model.size() < 3) continue;
      const Moments whole = MomentsOf(model);
      if (!(whole.spread > 1e-6)) continue;
      InitialAlignment alignment;
      Similarity3& camera_from_object = alignment.camera_from_object;
      camera_from_object.rotation = UprightRotation(view.up_camera, level.normalized(), azimuth);
      camera_from_object.scale = std::clamp(seen.spread / whole.spread, min_scale_m, max_scale_m);
      camera_from_object.translation_m =
          seen.centroid - camera_from_object.scale * (camera_from_object.rotation * whole.centroid);
      for (Eigen::Vector3d& point : model) point = camera_from_object * point;
      alignment.error_m = PointToPointError(measured, model);
      alignments.push_back(alignment);
    }
  }
  std::stable_sort(alignments.begin(), alignments.end(), [](const auto& a, const auto& b) {
    return a.error_m < b.error_m;
  });
  return alignments;
}

}  // namespace deepslam::registration
