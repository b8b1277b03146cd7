#include "deepslam/eval/layout_score.h"
#include "deepslam/core/angles.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

namespace deepslam::eval {
namespace {

constexpr double kScoreStep_m = 0.05;  // lengths are counted in steps of this
constexpr double kSeenHeight_m = 0.3;  // of a step of wall, to call it seen

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// A line with ends, stepped through.
struct Segment {
  Eigen::Vector2d from_m;
  Eigen::Vector2d along;
  double length_m = 0;

  Segment(const Eigen::Vector2d& from, const Eigen::Vector2d& to)
      : from_m(from), along((to - from).normalized()), length_m((to - from).norm()) {}
  [[nodiscard]] int num_steps() const {
    return std::max(1, static_cast<int>(std::lround(length_m / kScoreStep_m)));
  }
  [[nodiscard]] Eigen::Vector2d Step(int n) const {
    return from_m + (n + 0.5) * length_m / num_steps() * along;
  }
  [[nodiscard]] double Position(const Eigen::Vector2d& p) const { return along.dot(p - from_m); }
  [[nodiscard]] double Distance(const Eigen::Vector2d& p) const {
    return std::abs(Cross(along, p - from_m));
  }
};

Segment SegmentOf(const TrueWall& wall) { return {wall.from_m, wall.to_m}; }
Segment SegmentOf(const LayoutWall& wall) { return {wall.from_m, wall.to_m}; }

double AngleBetween(const Segment& a, const Segment& b) {
  return std::asin(std::min(1.0, std::abs(Cross(a.along, b.along))));
}

// The direction of a wall in a thick box is known no better than its diagonal.
double AngleLimit(const TrueWall& wall, const LayoutScoreOptions& options) {
  const double length_m = (wall.to_m - wall.from_m).norm();
  return options.max_angle_deg * kRadPerDeg + std::atan2(wall.thickness_m, length_m);
}

// Whether a place of the true wall is covered by the estimated one.
bool Covers(const Segment& estimated,
            const TrueWall& truth,
            const Eigen::Vector2d& p,
            const LayoutScoreOptions& options) {
  const double at_m = estimated.Position(p);
  return at_m > -options.max_distance_m && at_m < estimated.length_m + options.max_distance_m &&
         estimated.Distance(p) < options.max_distance_m + truth.thickness_m / 2;
}

// Steps of the true wall of which the surface was seen.
std::vector<bool> SeenSteps(const TrueWall& wall,
                            const std::vector<Eigen::Vector3d>& points,
                            const LayoutScoreOptions& options) {
  const Segment segment = SegmentOf(wall);
  const int num_steps = segment.num_steps();
  constexpr int kHeightRows = 64;  // of kScoreStep_m: 3.2 m
  std::vector<std::uint64_t> rows(static_cast<std::size_t>(num_steps), 0);
  for (const Eigen::Vector3d& p : points) {
    const double at_m = segment.Position(p.head<2>());
    if (at_m < 0 || at_m >= segment.length_m || p.z() < wall.bottom_m || p.z() > wall.top_m ||
        segment.Distance(p.head<2>()) > options.max_distance_m + wall.thickness_m / 2)
      continue;
    const auto step = static_cast<std::size_t>(
        std::min(num_steps - 1, static_cast<int>(at_m / segment.length_m * num_steps)));
    const int row = static_cast<int>((p.z() - wall.bottom_m) / kScoreStep_m);
    if (row < kHeightRows) rows[step] |= std::uint64_t{1} << static_cast<unsigned>(row);
  }
  std::vector<bool> seen;
  for (const std::uint64_t bits : rows)
    seen.push_back(std::popcount(bits) * kScoreStep_m >= kSeenHeight_m);
  return seen;
}

struct SeenWall {
  const TrueWall* wall = nullptr;
  std::vector<bool> seen;
  double seen_m = 0;
};

bool IsFound(const SeenWall& truth, const Layout& layout, const LayoutScoreOptions& options) {
  const Segment segment = SegmentOf(*truth.wall);
  int num_seen = 0;
  int num_covered = 0;
  for (int n = 0; n < segment.num_steps(); ++n) {
    if (!truth.seen[static_cast<std::size_t>(n)]) continue;
    ++num_seen;
    const bool covered =
        std::any_of(layout.walls.begin(), layout.walls.end(), [&](const LayoutWall& wall) {
          const Segment estimated = SegmentOf(wall);
          return AngleBetween(estimated, segment) < AngleLimit(*truth.wall, options) &&
                 Covers(estimated, *truth.wall, segment.Step(n), options);
        });
    num_covered += covered ? 1 : 0;
  }
  return num_covered >= options.min_share * num_seen;
}

bool IsRight(const LayoutWall& wall, const TrueLayout& truth, const LayoutScoreOptions& options) {
  const Segment segment = SegmentOf(wall);
  int num_covered = 0;
  for (int n = 0; n < segment.num_steps(); ++n) {
    const Eigen::Vector2d p = segment.Step(n);
    const bool covered =
        std::any_of(truth.walls.begin(), truth.walls.end(), [&](const TrueWall& other) {
          const Segment true_segment = SegmentOf(other);
          const double at_m = true_segment.Position(p);
          return AngleBetween(segment, true_segment) < AngleLimit(other, options) &&
                 at_m > -options.max_distance_m &&
                 at_m < true_segment.length_m + options.max_distance_m &&
                 true_segment.Distance(p) < options.max_distance_m + other.thickness_m / 2;
        });
    num_covered += covered ? 1 : 0;
  }
  return num_covered >= options.min_share * segment.num_steps();
}

void ScoreWalls(const Layout& layout,
                const TrueLayout& truth,
                const std::vector<SeenWall>& seen,
                const LayoutScoreOptions& options,
                LayoutScore& score) {
  for (std::size_t n = 0; n < seen.size(); ++n) {
    if (seen[n].seen_m < options.min_wall_m) continue;
    ++score.num_true_walls;
    if (IsFound(seen[n], layout, options)) {
      ++score.num_found_walls;
    } else {
      score.missed_walls.push_back(static_cast<int>(n));
    }
  }
  for (std::size_t n = 0; n < layout.walls.size(); ++n) {
    ++score.num_walls;
    if (IsRight(layout.walls[n], truth, options)) {
      ++score.num_right_walls;
    } else {
      score.wrong_walls.push_back(static_cast<int>(n));
    }
  }
}

// Whether a wall that ends at a corner was seen near it.
bool SeenNear(const Eigen::Vector2d& corner, const SeenWall& wall) {
  // A corner is seen where the last half metre of the wall is.
  constexpr double kNearCorner_m = 0.5;
  const Segment segment = SegmentOf(*wall.wall);
  for (int n = 0; n < segment.num_steps(); ++n) {
    if (wall.seen[static_cast<std::size_t>(n)] && (segment.Step(n) - corner).norm() < kNearCorner_m)
      return true;
  }
  return false;
}

void ScoreCorners(const Layout& layout,
                  const TrueLayout& truth,
                  const std::vector<SeenWall>& seen,
                  LayoutScore& score) {
  // Walls of the truth that meet in a corner end this near to it.
  constexpr double kSameCorner_m = 0.02;
  for (const std::vector<Eigen::Vector2d>& room : truth.rooms) {
    for (const Eigen::Vector2d& corner : room) {
      const auto num_seen = std::count_if(seen.begin(), seen.end(), [&](const SeenWall& wall) {
        const bool ends_here = (wall.wall->from_m - corner).norm() < kSameCorner_m ||
                               (wall.wall->to_m - corner).norm() < kSameCorner_m;
        return ends_here && SeenNear(corner, wall);
      });
      if (num_seen < 2) continue;
      double nearest_m = std::numeric_limits<double>::infinity();
      for (const LayoutRoom& estimated : layout.rooms) {
        for (const Eigen::Vector2d& p : estimated.polygon_m)
          nearest_m = std::min(nearest_m, (p - corner).norm());
      }
      score.corner_m.push_back(nearest_m);
    }
  }
}

// Of the area of both, counted on a raster over the first.
double SharedArea(const std::vector<Eigen::Vector2d>& a, const std::vector<Eigen::Vector2d>& b) {
  constexpr double kRaster_m = 0.05;  // a room of 10 m^2 has 4,000 samples
  Eigen::Vector2d low = a.front();
  Eigen::Vector2d high = a.front();
  for (const Eigen::Vector2d& p : a) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  int count = 0;
  for (double x = low.x() + kRaster_m / 2; x < high.x(); x += kRaster_m) {
    for (double y = low.y() + kRaster_m / 2; y < high.y(); y += kRaster_m)
      count += IsInside(a, {x, y}) && IsInside(b, {x, y}) ? 1 : 0;
  }
  return count * kRaster_m * kRaster_m;
}

void ScoreRooms(const Layout& layout, const TrueLayout& truth, LayoutScore& score) {
  constexpr double kMostly = 0.5;  // of both areas: the same room
  for (const std::vector<Eigen::Vector2d>& room : truth.rooms) {
    ++score.num_true_rooms;
    const double true_m2 = std::abs(AreaOf(room));
    for (const LayoutRoom& estimated : layout.rooms) {
      const double area_m2 = std::abs(AreaOf(estimated.polygon_m));
      const double shared_m2 = SharedArea(room, estimated.polygon_m);
      if (shared_m2 < kMostly * std::max(true_m2, area_m2)) continue;
      score.room_area_error.push_back(std::abs(area_m2 - true_m2) / true_m2);
      break;
    }
  }
}

struct Interval {
  double low = 0;
  double high = 0;
  [[nodiscard]] double length() const { return std::max(0.0, high - low); }
};
Interval Common(const Interval& a, const Interval& b) {
  return {std::max(a.low, b.low), std::min(a.high, b.high)};
}

// In the plane of the estimated opening's wall; 0 where the true one is too far from it.
double OpeningIou(const LayoutOpening& estimated,
                  const TrueOpening& truth,
                  const LayoutScoreOptions& options) {
  const Segment segment(estimated.from_m, estimated.to_m);
  const Eigen::Vector2d along = (truth.to_m - truth.from_m).normalized();
  const Eigen::Vector2d across(-along.y(), along.x());
  Interval true_width{1e9, -1e9};
  double nearest_m = 1e9;
  for (const Eigen::Vector2d& end : {truth.from_m, truth.to_m}) {
    for (const double side : {-0.5, 0.5}) {
      const Eigen::Vector2d corner = end + side * truth.thickness_m * across;
      true_width.low = std::min(true_width.low, segment.Position(corner));
      true_width.high = std::max(true_width.high, segment.Position(corner));
      nearest_m = std::min(nearest_m, segment.Distance(corner));
    }
  }
  const Eigen::Vector2d middle = 0.5 * (truth.from_m + truth.to_m);
  if (std::min(nearest_m, segment.Distance(middle)) > options.max_opening_depth_m) return 0;
  const Interval width{0, segment.length_m};
  const Interval height{estimated.bottom_m, estimated.top_m};
  const Interval true_height{truth.bottom_m, truth.top_m};
  const double common = Common(width, true_width).length() * Common(height, true_height).length();
  const double both =
      width.length() * height.length() + true_width.length() * true_height.length() - common;
  return both > 0 ? common / both : 0;
}

void ScoreOpenings(const Layout& layout,
                   const TrueLayout& truth,
                   const LayoutScoreOptions& options,
                   LayoutScore& score) {
  const auto found_as = [&](const TrueOpening& opening, bool any_kind) {
    return std::any_of(
        layout.openings.begin(), layout.openings.end(), [&](const LayoutOpening& estimated) {
          return (any_kind || estimated.kind == opening.kind) &&
                 OpeningIou(estimated, opening, options) >= options.min_opening_iou;
        });
  };
  for (const OpeningKind kind : {OpeningKind::kDoor, OpeningKind::kWindow, OpeningKind::kPassage}) {
    KindScore row;
    row.kind = kind;
    for (const LayoutOpening& estimated : layout.openings)
      row.num_estimated += estimated.kind == kind ? 1 : 0;
    for (const TrueOpening& opening : truth.openings) {
      if (opening.kind != kind) continue;
      ++row.num_true;
      row.num_found += found_as(opening, false) ? 1 : 0;
    }
    row.num_found = std::min(row.num_found, row.num_estimated);
    score.openings.push_back(row);
  }
  for (const TrueOpening& opening : truth.openings)
    score.num_openings_any_kind += found_as(opening, true) ? 1 : 0;
}

double Share(int part, int whole) { return whole > 0 ? static_cast<double>(part) / whole : 1.0; }

}  // namespace

double KindScore::precision() const { return Share(num_found, num_estimated); }
double KindScore::recall() const { return Share(num_found, num_true); }
double KindScore::f1() const {
  return num_true + num_estimated > 0 ? 2.0 * num_found / (num_true + num_estimated) : 1.0;
}

double LayoutScore::wall_recall() const { return Share(num_found_walls, num_true_walls); }
double LayoutScore::wall_precision() const { return Share(num_right_walls, num_walls); }

LayoutScore ScoreLayout(const Layout& layout,
                        const TrueLayout& truth,
                        const std::vector<Eigen::Vector3d>& seen_points,
                        const LayoutScoreOptions& options) {
  std::vector<SeenWall> seen;
  for (const TrueWall& wall : truth.walls) {
    SeenWall of{&wall, SeenSteps(wall, seen_points, options), 0};
    const Segment segment = SegmentOf(wall);
    of.seen_m = static_cast<double>(std::count(of.seen.begin(), of.seen.end(), true)) *
                segment.length_m / segment.num_steps();
    seen.push_back(std::move(of));
  }
  LayoutScore score;
  ScoreWalls(layout, truth, seen, options, score);
  ScoreCorners(layout, truth, seen, score);
  ScoreRooms(layout, truth, score);
  ScoreOpenings(layout, truth, options, score);
  return score;
}

}  // namespace deepslam::eval
