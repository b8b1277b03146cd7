#include "deepslam/layout/furniture_fronts.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "deepslam/core/angles.h"

namespace deepslam::layout {
namespace {

// Wardrobes and tall cupboards are 0.5 to 0.7 m deep with their doors and handles. Shelves, which
// are less, hide no wall from a camera that walks by.
constexpr double kShallowest_m = 0.4;
constexpr double kDeepest_m = 0.75;   // with what measuring adds
constexpr double kNearest_m = 0.2;    // farther from a wall than what hangs on it (select_lines.cc)
constexpr double kNarrowest_m = 0.4;  // what is seen of a front of two leaves
constexpr double kLongest_m = 3.0;    // of what shops sell
constexpr double kBelowUsual_m = 0.1;  // two cells: a wall's uppermost cells are uneven by one
constexpr double kParallel_deg = 8;    // as walls that face the same way (select_lines.cc)
// Of the wall behind a front: what the camera sees past its ends.
constexpr double kMostShown = 0.25;
constexpr double kLeastShown = 0.75;  // or below and above, where it is no front from floor to top
constexpr double kBeside_m = 1.5;     // beside it, where other furniture hides some of it
constexpr double kLeastBeside = 0.1;  // of that: 15 cm of wall
constexpr double kSlack_m = 0.15;     // of where a side ends
constexpr double kUnseen_m = 0.6;     // of a front, next to its side

struct Run {
  std::size_t line = 0;
  int first = 0;  // slots, as [first, end)
  int end = 0;
  double from_m = 0;  // along the line
  double to_m = 0;

  [[nodiscard]] double Length() const { return to_m - from_m; }
};

std::vector<Run> RunsOf(const WallLines& walls) {
  std::vector<Run> runs;
  for (std::size_t n = 0; n < walls.lines.size(); ++n) {
    const WallProfile& profile = walls.profiles[n];
    for (const auto& [first, end] : profile.WallRuns())
      runs.push_back({n, first, end, profile.PositionOf(first), profile.PositionOf(end)});
  }
  return runs;
}

struct Interval {
  double low = 0;
  double high = 0;
};

// Of a run along another line, or before it.
Interval Along(const WallLine& line, const WallLine& of_run, const Run& run) {
  const double a = line.along().dot(of_run.At(run.from_m));
  const double b = line.along().dot(of_run.At(run.to_m));
  return {std::min(a, b), std::max(a, b)};
}

Interval Before(const WallLine& line, const WallLine& of_run, const Run& run) {
  const double a = line.Distance(of_run.At(run.from_m));
  const double b = line.Distance(of_run.At(run.to_m));
  return {std::min(a, b), std::max(a, b)};
}

double CosineBetween(const WallLine& a, const WallLine& b) { return a.normal.dot(b.normal); }

// The part of line k that the run stands before, which faces its way; nothing where that is nearer
// or farther.
std::optional<Interval> PartBehind(const WallLines& walls,
                                   std::size_t k,
                                   const Run& run,
                                   double nearest_m) {
  const WallLine& front = walls.lines[run.line];
  if (CosineBetween(walls.lines[k], front) < std::cos(kParallel_deg * kRadPerDeg))
    return std::nullopt;
  const Interval before = Before(walls.lines[k], front, run);
  if (before.low < nearest_m || before.high > kDeepest_m) return std::nullopt;
  return Along(walls.lines[k], front, run);
}

bool HidesWallOf(const WallLines& walls, std::size_t k, const Run& run) {
  const std::optional<Interval> hidden = PartBehind(walls, k, run, kShallowest_m);
  if (!hidden) return false;
  const WallProfile& wall = walls.profiles[k];
  return wall.WallShare(hidden->low, hidden->high) <= kMostShown &&
         std::max(wall.WallShare(hidden->low - kBeside_m, hidden->low),
                  wall.WallShare(hidden->high, hidden->high + kBeside_m)) >= kLeastBeside;
}

// Whether wall of line k was seen behind it all along, below or above: two walls have a room
// between them.
bool ShowsWallOf(const WallLines& walls, std::size_t k, const Run& run) {
  const std::optional<Interval> shown = PartBehind(walls, k, run, kNearest_m);
  return shown && walls.profiles[k].WallShare(shown->low, shown->high) >= kLeastShown;
}

struct Front {
  Run run;
  std::size_t wall = 0;  // line of the wall behind it
};

std::vector<Front> FindFronts(const WallLines& walls,
                              const std::vector<Run>& runs,
                              double usual_top_m) {
  std::vector<Front> fronts;
  for (const Run& run : runs) {
    if (run.Length() < kNarrowest_m || run.Length() > kLongest_m) continue;
    const bool is_low =
        walls.profiles[run.line].SeenTop(run.first, run.end) <= usual_top_m - kBelowUsual_m;
    for (std::size_t k = 0; k < walls.lines.size(); ++k) {
      if (k == run.line) continue;
      if (!ShowsWallOf(walls, k, run) && !(is_low && HidesWallOf(walls, k, run))) continue;
      fronts.push_back({run, k});
      break;
    }
  }
  return fronts;
}

// Whether a run joins a front to the wall behind it.
bool IsSideOf(const WallLines& walls, const Front& front, const Run& run) {
  const WallLine& side = walls.lines[run.line];
  const WallLine& wall = walls.lines[front.wall];
  const WallLine& before = walls.lines[front.run.line];
  if (std::abs(CosineBetween(side, wall)) > std::sin(kParallel_deg * kRadPerDeg)) return false;
  const Interval depth = Before(wall, side, run);
  const Interval of_front = Before(wall, before, front.run);
  if (depth.low < -kSlack_m || depth.high > of_front.high + kSlack_m) return false;
  const Interval at = Along(before, side, run);
  return at.low > front.run.from_m - kUnseen_m && at.high < front.run.to_m + kUnseen_m;
}

void TakeOut(const Run& run, WallLines& walls) {
  std::vector<std::uint8_t>& is_wall = walls.profiles[run.line].is_wall;
  std::fill(is_wall.begin() + run.first, is_wall.begin() + run.end, std::uint8_t{0});
}

}  // namespace

void DropFurniture(double usual_top_m, WallLines& walls) {
  const std::vector<Run> runs = RunsOf(walls);
  const std::vector<Front> fronts = FindFronts(walls, runs, usual_top_m);
  std::vector<Run> dropped;
  for (const Front& front : fronts) {
    dropped.push_back(front.run);
    std::ranges::copy_if(runs, std::back_inserter(dropped), [&](const Run& run) {
      return IsSideOf(walls, front, run);
    });
  }
  for (const Run& run : dropped) TakeOut(run, walls);
  WallLines kept;
  for (std::size_t n = 0; n < walls.lines.size(); ++n) {
    const bool was_touched = std::ranges::count(dropped, n, &Run::line) > 0;
    if (was_touched && walls.profiles[n].WallRuns().empty()) continue;
    kept.lines.push_back(walls.lines[n]);
    kept.profiles.push_back(std::move(walls.profiles[n]));
  }
  walls = std::move(kept);
}

}  // namespace deepslam::layout
