#include "deepslam/detect/find_walls.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>

#include <Eigen/Eigenvalues>

#include "deepslam/core/order_statistics.h"
#include "deepslam/core/wide_vectors.h"

namespace deepslam::detect {
namespace {

constexpr int kMostWalls = 4;  // a view of a room shows its corner and a wall or two beside it
// 4 deg apart: 1 m from a wall's middle its points are off by 3.5 cm at most.
constexpr int kNumAngles = 90;
// Bins of the vote: wide enough for the noise of depth, so that votes meet.
constexpr double kDistanceStep_m = 0.06;
// From the camera's foot; as bins of kDistanceStep_m it still fits a byte.
constexpr double kWallReach_m = 8;
constexpr double kMinWallHeight_m = 1.5;  // what is lower is furniture, unless the picture cuts it
constexpr double kMinWallLength_m = 1.0;  // shorter upright faces are sides of furniture
constexpr double kMinWallShare = 0.1;     // of the area of all upright points
constexpr double kMaxBeyond = 0.15;       // of the wall's own area
constexpr double kTopShare = 0.02;        // of the wall's points that lie at the picture's top
constexpr std::size_t kWallOutermost = 50;  // part of the points at either end that may be noise

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

constexpr std::size_t kNumDistances = static_cast<std::size_t>(kWallReach_m / kDistanceStep_m);
// Where points out of reach vote; in turn, so that a vote need not wait for the last.
constexpr std::size_t kNumNowhere = 8;
constexpr std::size_t kNumVoteBins = kNumDistances + kNumNowhere;
static_assert(kNumVoteBins <= 256);

// The bin of each point's distance along a direction.
DEEPSLAM_WIDE_VECTORS void FindBins(const std::vector<double>& x_m,
                                    const std::vector<double>& y_m,
                                    const Eigen::Vector2d& direction,
                                    std::uint8_t* bins) {
  // Steps are clamped to it: rounding may exceed it by one.
  constexpr std::int32_t kLastDistance = static_cast<std::int32_t>(kNumDistances) - 1;
  const double* const x = x_m.data();
  const double* const y = y_m.data();
  const double direction_x = direction.x();
  const double direction_y = direction.y();
  const auto count = static_cast<std::int32_t>(x_m.size());
#pragma GCC ivdep
  for (std::int32_t n = 0; n < count; ++n) {
    const double distance_m = direction_x * x[n] + direction_y * y[n];
    const bool in_reach = (distance_m > 0) & (distance_m < kWallReach_m);
    const auto step = static_cast<std::int32_t>(in_reach ? distance_m / kDistanceStep_m : 0.0);
    const std::int32_t nowhere =
        kLastDistance + 1 + (n & (static_cast<std::int32_t>(kNumNowhere) - 1));
    bins[n] = static_cast<std::uint8_t>(in_reach ? std::min(step, kLastDistance) : nowhere);
  }
}

// Finds the line with the most area on it (Hough), to half a step.
class LineVotes {
 public:
  explicit LineVotes(std::span<const UprightPoint> points)
      : directions_(AllDirections()), bins_(kNumAngles * points.size()) {
    std::vector<double> x_m;
    std::vector<double> y_m;
    for (const UprightPoint& point : points) {
      x_m.push_back(point.on_ground_m.x());
      y_m.push_back(point.on_ground_m.y());
      areas_.push_back(AreaOf(point));
    }
    for (std::size_t angle = 0; angle < kNumAngles; ++angle) {
      FindBins(x_m, y_m, directions_[angle], bins_.data() + angle * points.size());
    }
  }

  [[nodiscard]] std::optional<Wall> Strongest(const std::vector<bool>& taken) const {
    std::vector<std::uint32_t> voters;
    for (std::size_t n = 0; n < areas_.size(); ++n) {
      if (!taken[n]) voters.push_back(static_cast<std::uint32_t>(n));
    }
    Wall wall;
    double most = 0;
    for (std::size_t angle = 0; angle < kNumAngles; angle += kAnglesAtOnce) {
      const Votes votes = Count(voters, angle);
      for (std::size_t k = 0; k < kAnglesAtOnce; ++k) {
        const auto best = std::max_element(votes[k].begin(), votes[k].begin() + kNumDistances);
        if (*best <= most) continue;
        most = *best;
        wall = {directions_[angle + k],
                (static_cast<double>(best - votes[k].begin()) + 0.5) * kDistanceStep_m};
      }
    }
    if (!(most > 0)) return std::nullopt;
    return wall;
  }

 private:
  // Angles counted side by side, since votes of neighbours in one bin wait for each other.
  static constexpr std::size_t kAnglesAtOnce = 10;
  static_assert(kNumAngles % kAnglesAtOnce == 0);
  using Votes = std::array<std::array<double, kNumVoteBins>, kAnglesAtOnce>;

  [[nodiscard]] Votes Count(std::span<const std::uint32_t> voters, std::size_t first) const {
    Votes votes{};
    for (const std::uint32_t n : voters) {
      for (std::size_t k = 0; k < kAnglesAtOnce; ++k) {
        votes[k][bins_[(first + k) * areas_.size() + n]] += areas_[n];
      }
    }
    return votes;
  }

  Directions directions_;
  std::vector<std::uint8_t> bins_;  // of all points by direction
  std::vector<double> areas_;
};

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
  if (heights_m.empty() || area < kMinWallShare * area_all || area_beyond > kMaxBeyond * area)
    return false;
  const auto [first_m, last_m] = InnerRange(places_m, kWallOutermost);
  if (last_m - first_m < kMinWallLength_m) return false;
  return InnerRange(heights_m, kWallOutermost).second > kMinWallHeight_m ||
         static_cast<double>(num_at_top) > kTopShare * static_cast<double>(heights_m.size());
}

}  // namespace

double WallTolerance_m(double depth_m) { return 0.04 + 0.006 * depth_m * depth_m; }

std::vector<Wall> FindWalls(std::span<const UprightPoint> points) {
  std::vector<Wall> walls;
  std::vector<bool> taken(points.size(), false);
  const LineVotes votes(points);
  for (int attempt = 0; attempt < kMostWalls; ++attempt) {
    std::optional<Wall> wall = votes.Strongest(taken);
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
