#include "deepslam/detect/find_walls.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>

#include <Eigen/Eigenvalues>

#include "deepslam/core/order_statistics.h"

namespace deepslam::detect {
namespace {

constexpr int kMostWalls = 4;
constexpr int kNumAngles = 90;
constexpr double kStep_m = 0.06;
constexpr double kReach_m = 8;
constexpr double kMinHeight_m = 1.5;
constexpr double kMinLength_m = 1.0;
constexpr double kMinShare = 0.1;       // of the area of all upright points
constexpr double kMaxBeyond = 0.15;     // of the wall's own area
constexpr double kTopShare = 0.02;      // of the wall's points that lie at the picture's top
constexpr std::size_t kOutermost = 50;  // part of the points at either end that may be noise

double AreaOf(const UprightPoint& point) { return point.depth_m * point.depth_m; }

Eigen::Vector2d Direction(int angle) {
  const double rad = 2 * std::numbers::pi * angle / kNumAngles;
  return {std::cos(rad), std::sin(rad)};
}

using Directions = std::array<Eigen::Vector2d, kNumAngles>;

Directions AllDirections() {
  Directions directions;
  for (int angle = 0; angle < kNumAngles; ++angle)
    directions[static_cast<std::size_t>(angle)] = Direction(angle);
  return directions;
}

// The line with the most area on it (Hough), to half a step.
std::optional<Wall> StrongestLine(std::span<const UprightPoint> points,
                                  const std::vector<bool>& taken,
                                  const Directions& directions) {
  constexpr auto kNumSteps = static_cast<std::size_t>(kReach_m / kStep_m);
  std::vector<double> votes(kNumAngles * kNumSteps, 0.0);
  for (std::size_t n = 0; n < points.size(); ++n) {
    if (taken[n]) continue;
    for (std::size_t angle = 0; angle < kNumAngles; ++angle) {
      const double distance_m = directions[angle].dot(points[n].on_ground_m);
      if (!(distance_m > 0 && distance_m < kReach_m)) continue;
      const auto step = std::min(kNumSteps - 1, static_cast<std::size_t>(distance_m / kStep_m));
      votes[angle * kNumSteps + step] += AreaOf(points[n]);
    }
  }
  const auto best = std::max_element(votes.begin(), votes.end());
  if (!(*best > 0)) return std::nullopt;
  const auto at = static_cast<std::size_t>(best - votes.begin());
  return Wall{directions[at / kNumSteps], (static_cast<double>(at % kNumSteps) + 0.5) * kStep_m};
}

// Least squares on the points within twice the tolerance.
std::optional<Wall> Refined(std::span<const UprightPoint> points,
                            const std::vector<bool>& taken,
                            const Wall& start) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d products = Eigen::Matrix2d::Zero();
  double area = 0;
  for (std::size_t n = 0; n < points.size(); ++n) {
    const Eigen::Vector2d& p = points[n].on_ground_m;
    if (taken[n] || std::abs(start.Beyond(p)) > 2 * WallTolerance_m(points[n].depth_m)) continue;
    area += AreaOf(points[n]);
    sum += AreaOf(points[n]) * p;
    products += AreaOf(points[n]) * p * p.transpose();
  }
  if (!(area > 0)) return std::nullopt;
  const Eigen::Vector2d mean = sum / area;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(products / area -
                                                              mean * mean.transpose());
  Wall wall{solver.eigenvectors().col(0), 0};
  if (wall.normal.dot(mean) < 0) wall.normal = -wall.normal;
  wall.distance_m = wall.normal.dot(mean);
  if (!wall.normal.allFinite() || !(wall.distance_m > 0)) return std::nullopt;
  return wall;
}

bool IsWall(std::span<const UprightPoint> points, const Wall& wall) {
  const Eigen::Vector2d along(-wall.normal.y(), wall.normal.x());
  std::vector<double> heights_m;
  std::vector<double> places_m;
  std::size_t num_at_top = 0;
  double area = 0;
  double area_beyond = 0;
  double area_all = 0;
  for (const UprightPoint& point : points) {
    const double beyond_m = wall.Beyond(point.on_ground_m);
    const double tolerance_m = WallTolerance_m(point.depth_m);
    area_all += AreaOf(point);
    if (beyond_m > 2 * tolerance_m) area_beyond += AreaOf(point);
    if (std::abs(beyond_m) > tolerance_m) continue;
    area += AreaOf(point);
    num_at_top += point.at_top_edge ? 1U : 0U;
    heights_m.push_back(point.height_m);
    places_m.push_back(along.dot(point.on_ground_m));
  }
  if (heights_m.empty() || area < kMinShare * area_all || area_beyond > kMaxBeyond * area)
    return false;
  const auto [first_m, last_m] = InnerRange(places_m, kOutermost);
  if (last_m - first_m < kMinLength_m) return false;
  return InnerRange(heights_m, kOutermost).second > kMinHeight_m ||
         static_cast<double>(num_at_top) > kTopShare * static_cast<double>(heights_m.size());
}

}  // namespace

double WallTolerance_m(double depth_m) { return 0.04 + 0.006 * depth_m * depth_m; }

std::vector<Wall> FindWalls(std::span<const UprightPoint> points) {
  std::vector<Wall> walls;
  std::vector<bool> taken(points.size(), false);
  const Directions directions = AllDirections();
  for (int attempt = 0; attempt < kMostWalls; ++attempt) {
    std::optional<Wall> wall = StrongestLine(points, taken, directions);
    for (int round = 0; round < 3 && wall; ++round) wall = Refined(points, taken, *wall);
    if (!wall) break;
    for (std::size_t n = 0; n < points.size(); ++n) {
      if (std::abs(wall->Beyond(points[n].on_ground_m)) <= WallTolerance_m(points[n].depth_m))
        taken[n] = true;
    }
    if (IsWall(points, *wall)) walls.push_back(*wall);
  }
  return walls;
}

}  // namespace deepslam::detect
