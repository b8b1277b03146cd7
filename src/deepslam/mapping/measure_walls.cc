#include "deepslam/mapping/measure_walls.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>

#include "deepslam/core/angles.h"
#include "deepslam/frames/for_frames.h"
#include "deepslam/geometry/depth_noise.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/wall_geometry.h"

namespace deepslam::mapping {
namespace {

// A point of a frame and the normal of the surface there, towards the camera.
struct WallPoint {
  Eigen::Vector3d p_camera;
  Eigen::Vector3d normal_camera;
};

std::vector<WallPoint> WallPointsOf(const Frame& frame,
                                    const PinholeCamera& camera,
                                    const WallViewOptions& options) {
  const DepthImage& depth_m = frame.depth_m;
  const int step = options.step_px;
  std::vector<WallPoint> points;
  const auto at = [&](int u, int v) -> std::optional<Eigen::Vector3d> {
    const auto z = static_cast<double>(depth_m(u, v));
    if (!(z > 0) || z > options.max_depth_m) return std::nullopt;
    return camera.Unproject(u, v, z);
  };
  for (int v = step; v + step < depth_m.height(); v += step) {
    for (int u = step; u + step < depth_m.width(); u += step) {
      const auto middle = at(u, v);
      const auto left = at(u - step, v);
      const auto right = at(u + step, v);
      const auto above = at(u, v - step);
      const auto below = at(u, v + step);
      if (!middle || !left || !right || !above || !below) continue;
      const Eigen::Vector3d normal = (*below - *above).cross(*right - *left);
      const double length = normal.norm();
      if (length > 0) points.push_back({*middle, normal / length});
    }
  }
  return points;
}

// Of one wall in the level world.
class SeenWall {
 public:
  SeenWall(const LayoutWall& wall, const WallViewOptions& options)
      : wall_(wall),
        options_(options),
        along_(AlongOf(wall)),
        normal_(-along_.y(), along_.x(), 0),
        min_cosine_(std::cos(options.max_angle_deg * kRadPerDeg)) {}

  [[nodiscard]] Plane plane() const { return {normal_, -normal_.head<2>().dot(wall_.from_m)}; }
  [[nodiscard]] double Along(const Eigen::Vector3d& p) const {
    return along_.dot(p.head<2>() - wall_.from_m);
  }
  // Whether a surface with this normal at this place may be the wall's.
  [[nodiscard]] bool Holds(const Eigen::Vector3d& p, const Eigen::Vector3d& normal) const {
    constexpr double kWallFoot_m = 0.1;  // where walls meet the ground
    const double at_m = Along(p);
    return std::abs(plane().SignedDistance(p)) < options_.max_distance_m && at_m > 0 &&
           at_m < wall_.length_m() && p.z() > wall_.bottom_m + kWallFoot_m && p.z() < wall_.top_m &&
           normal.dot(normal_) > min_cosine_;
  }

 private:
  const LayoutWall& wall_;
  const WallViewOptions& options_;
  Eigen::Vector2d along_;
  Eigen::Vector3d normal_;
  double min_cosine_;
};

// Least squares over points on both sides of a first plane; nothing where too few lie near it.
std::optional<Plane> FittedPlane(const std::vector<Eigen::Vector3d>& points,
                                 Plane plane,
                                 const WallViewOptions& options) {
  constexpr int kFitRounds = 3;  // one with the wide bound, two within noise
  for (int round = 0; round < kFitRounds; ++round) {
    double weight = 0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
    for (const Eigen::Vector3d& p : points) {
      const double sigma_m = DepthSigmaM(p.z());
      // The first plane is as far off as the path is.
      const double bound_m =
          round == 0 ? options.max_distance_m : std::max(options.on_plane_m, 3 * sigma_m);
      if (std::abs(plane.SignedDistance(p)) > bound_m) continue;
      const double w = 1 / (sigma_m * sigma_m);
      weight += w;
      sum += w * p;
      products += w * p * p.transpose();
    }
    if (!(weight > 0)) return std::nullopt;
    const Eigen::Vector3d mean = sum / weight;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(products / weight -
                                                                mean * mean.transpose());
    Eigen::Vector3d normal = solver.eigenvectors().col(0);
    if (normal.dot(plane.normal) < 0) normal = -normal;
    plane = {normal, -normal.dot(mean)};
  }
  return plane;
}

class FrameWalls {
 public:
  FrameWalls(const Layout& layout, const WallViewOptions& options) : options_(options) {
    for (const LayoutWall& wall : layout.walls) walls_.emplace_back(wall, options);
  }

  void Measure(FrameIdx keyframe,
               const std::vector<WallPoint>& points,
               const Pose3& level_from_camera,
               std::vector<graph::WallView>& views) const {
    std::vector<std::vector<Eigen::Vector3d>> of_wall(walls_.size());
    for (const WallPoint& point : points) {
      const Eigen::Vector3d p = level_from_camera * point.p_camera;
      const Eigen::Vector3d normal = level_from_camera.rotation * point.normal_camera;
      // The nearest: walls stand before one another where they end.
      std::optional<std::size_t> nearest;
      for (std::size_t wall = 0; wall < walls_.size(); ++wall) {
        if (!walls_[wall].Holds(p, normal)) continue;
        if (!nearest || std::abs(walls_[wall].plane().SignedDistance(p)) <
                            std::abs(walls_[*nearest].plane().SignedDistance(p)))
          nearest = wall;
      }
      if (nearest) of_wall[*nearest].push_back(point.p_camera);
    }
    for (std::size_t wall = 0; wall < walls_.size(); ++wall) {
      if (auto view = ViewOf(walls_[wall], of_wall[wall], level_from_camera)) {
        view->keyframe = keyframe;
        view->wall = static_cast<int>(wall);
        views.push_back(*view);
      }
    }
  }

 private:
  [[nodiscard]] std::optional<graph::WallView> ViewOf(const SeenWall& wall,
                                                      const std::vector<Eigen::Vector3d>& points,
                                                      const Pose3& level_from_camera) const {
    if (static_cast<int>(points.size()) < options_.min_points) return std::nullopt;
    const Plane expected = Transformed(level_from_camera.Inverse(), wall.plane());
    const std::optional<Plane> plane = FittedPlane(points, expected, options_);
    if (!plane ||
        plane->normal.dot(expected.normal) < std::cos(0.5 * options_.max_angle_deg * kRadPerDeg))
      return std::nullopt;
    graph::WallView view;
    view.plane_camera = *plane;
    view.information.setZero();
    const Eigen::Matrix<double, 3, 2> tangents = GroundTangentBasis(plane->normal);
    std::vector<double> along_m;
    std::vector<double> up_m;
    for (const Eigen::Vector3d& p : points) {
      const double sigma_m = DepthSigmaM(p.z());
      if (std::abs(plane->SignedDistance(p)) > std::max(options_.on_plane_m, 3 * sigma_m)) continue;
      Eigen::Vector3d row;
      row << tangents.transpose() * p, 1;
      view.information += row * row.transpose() / (sigma_m * sigma_m);
      const Eigen::Vector3d p_level = level_from_camera * p;
      along_m.push_back(wall.Along(p_level));
      up_m.push_back(p_level.z());
    }
    view.num_inliers = static_cast<int>(along_m.size());
    if (view.num_inliers < options_.min_points || MiddleExtent(along_m) < options_.min_extent_m ||
        MiddleExtent(up_m) < options_.min_extent_m)
      return std::nullopt;
    return view;
  }

  // Of all but the outermost twentieths.
  static double MiddleExtent(std::vector<double>& values) {
    constexpr std::size_t kTwentieths = 20;  // a twentieth at either end
    std::sort(values.begin(), values.end());
    const std::size_t left_out = values.size() / kTwentieths;
    return values[values.size() - 1 - left_out] - values[left_out];
  }

  const WallViewOptions& options_;
  std::vector<SeenWall> walls_;
};

}  // namespace

Result<graph::WallViews> MeasureWalls(const FrameSource& frames,
                                      const Trajectory& trajectory,
                                      const Layout& layout,
                                      const WallViewOptions& options,
                                      Progress& progress) {
  graph::WallViews found;
  const Pose3 world_from_level = layout.level_from_tracking.Inverse();
  const FrameWalls walls(layout, options);
  for (const LayoutWall& wall : layout.walls)
    found.planes.push_back(Transformed(world_from_level, SeenWall(wall, options).plane()));
  if (layout.walls.empty()) return found;
  const Status status = ForFrames(
      frames,
      trajectory.keyframes,
      progress,
      [&](const Frame& frame) {
        walls.Measure(frame.idx,
                      WallPointsOf(frame, frames.camera(), options),
                      layout.level_from_tracking * trajectory.at(frame.idx).world_from_camera,
                      found.views);
        return Ok();
      },
      FrameContent::kDepth);
  if (!status.ok()) return status.error();
  return found;
}

}  // namespace deepslam::mapping
