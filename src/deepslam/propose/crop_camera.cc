#include "deepslam/propose/crop_camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Geometry>

#include "deepslam/geometry/upright.h"

namespace deepslam::propose {
namespace {

// Side of the square by the silhouette's extent: 5 % stay free at either border.
constexpr double kMargin = 1.1;
constexpr double kLeastLevel = 0.2;  // sine between the axis and the vertical that tells up

// First and last pixel of each row: all that bounds a silhouette, whichever way it is turned.
std::vector<Eigen::Vector2d> RowEnds(const Mask& silhouette) {
  std::vector<Eigen::Vector2d> ends;
  for (int v = 0; v < silhouette.height(); ++v) {
    const std::uint8_t* const row = silhouette.row(v);
    const std::uint8_t* const end = row + silhouette.width();
    const std::uint8_t* const first =
        std::find_if(row, end, [](std::uint8_t inside) { return inside != 0; });
    if (first == end) continue;
    const std::uint8_t* last = end - 1;
    while (*last == 0) --last;
    for (const double down : {-0.5, 0.5}) {
      ends.emplace_back(static_cast<double>(first - row) - 0.5, v + down);
      ends.emplace_back(static_cast<double>(last - row) + 0.5, v + down);
    }
  }
  return ends;
}

struct Bounds {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = -low;

  void Add(const Eigen::Vector2d& point) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  [[nodiscard]] Eigen::Vector2d middle() const { return 0.5 * (low + high); }
};

Eigen::Matrix3d LookAlong(const Eigen::Vector3d& forward,
                          const std::optional<Plane>& ground_camera,
                          QuarterTurn upright) {
  const auto across = [&](const Eigen::Vector3d& direction) -> Eigen::Vector3d {
    return direction - direction.dot(forward) * forward;
  };
  Eigen::Vector3d down = across(Turned(Eigen::Vector3d(0, 1, 0), Inverse(upright)));
  if (ground_camera) {
    const Eigen::Vector3d by_ground = across(-ground_camera->normal);
    if (by_ground.norm() > kLeastLevel) down = by_ground;
  }
  down.normalize();
  Eigen::Matrix3d view_from_crop;
  view_from_crop << down.cross(forward), down, forward;
  return view_from_crop;
}

}  // namespace

std::optional<CropCamera> AimAt(const Mask& silhouette,
                                const PinholeCamera& camera,
                                const std::optional<Plane>& ground_camera,
                                QuarterTurn upright) {
  const std::vector<Eigen::Vector2d> ends = RowEnds(silhouette);
  if (ends.empty()) return std::nullopt;
  Bounds picture;
  for (const Eigen::Vector2d& end : ends) picture.Add(end);
  CropCamera crop;
  crop.view_from_crop = LookAlong(
      camera.Ray(picture.middle().x(), picture.middle().y()).normalized(), ground_camera, upright);
  Bounds square;
  for (const Eigen::Vector2d& end : ends) {
    const Eigen::Vector3d ray = crop.view_from_crop.transpose() * camera.Ray(end.x(), end.y());
    square.Add(ray.hnormalized());
  }
  crop.side = kMargin * (square.high - square.low).maxCoeff();
  crop.left = square.middle().x() - 0.5 * crop.side;
  crop.top = square.middle().y() - 0.5 * crop.side;
  return crop;
}

std::optional<double> ElevationOf(const CropCamera& crop,
                                  const std::optional<Plane>& ground_camera) {
  if (!ground_camera) return std::nullopt;
  const double rise = -ground_camera->normal.dot(crop.view_from_crop.col(2));
  return std::asin(std::clamp(rise, -1.0, 1.0));
}

}  // namespace deepslam::propose
