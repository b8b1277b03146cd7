#include "deepslam/synth/free_floor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace deepslam::synth {
namespace {

constexpr double kClearance_m = 0.28;  // between the camera and what stands there or walls
// Where there is room, people stay so far from walls, as if the way along them were so many times
// as long.
constexpr double kComfort_m = 0.55;
constexpr double kDiscomfort = 3;  // of a cell nearer than kComfort_m; others cost 1

bool IsFree(const HomePlan& plan,
            const std::vector<FloorRectangle>& taken,
            const Eigen::Vector2d& p,
            double clearance_m) {
  const FloorRectangle about{p.array() - clearance_m, p.array() + clearance_m};
  const bool in_room = std::ranges::any_of(
      plan.rooms, [&](const PlannedRoom& room) { return room.floor.Contains(about); });
  const bool in_door = std::ranges::any_of(plan.doors, [&](const PlannedDoor& door) {
    const Eigen::Vector2d away = p - door.middle_m;
    const Eigen::Vector2d across(-door.through.y(), door.through.x());
    return std::abs(away.dot(door.through)) < 0.5 && std::abs(away.dot(across)) < 0.12;
  });
  const bool meets = std::ranges::any_of(
      taken, [&](const FloorRectangle& piece) { return about.Overlaps(piece); });
  return (in_room || in_door) && !meets;
}

}  // namespace

FreeFloor::FreeFloor(const HomePlan& plan, const std::vector<FloorRectangle>& taken)
    : half_(plan.size_m.head<2>() / 2),
      nx_(static_cast<int>(plan.size_m.x() / kCell_m)),
      ny_(static_cast<int>(plan.size_m.y() / kCell_m)),
      free_(static_cast<std::size_t>(nx_ * ny_), 0),
      effort_(free_.size(), kDiscomfort) {
  for (int n = 0; n < nx_ * ny_; ++n) {
    const auto cell = static_cast<std::size_t>(n);
    free_[cell] = IsFree(plan, taken, PlaceOf(n), kClearance_m) ? 1 : 0;
    if (IsFree(plan, taken, PlaceOf(n), kComfort_m)) effort_[cell] = 1;
  }
  KeepLargestPart();
}

Eigen::Vector2d FreeFloor::PlaceOf(int cell) const {
  return {-half_.x() + (cell % nx_ + 0.5) * kCell_m, -half_.y() + (cell / nx_ + 0.5) * kCell_m};
}

std::optional<int> FreeFloor::Nearest(const Eigen::Vector2d& place,
                                      const FloorRectangle& within) const {
  std::optional<int> nearest;
  double best = std::numeric_limits<double>::infinity();
  for (int n = 0; n < nx_ * ny_; ++n) {
    const Eigen::Vector2d p = PlaceOf(n);
    if (free_[static_cast<std::size_t>(n)] == 0 || !within.Contains({p, p})) continue;
    if (const double away = (p - place).norm(); away < best) {
      best = away;
      nearest = n;
    }
  }
  return nearest;
}

std::vector<int> FreeFloor::Way(int from, int to) const {
  constexpr std::array<std::pair<int, int>, 8> kSteps = {
      {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}}};
  std::vector<double> cost(free_.size(), std::numeric_limits<double>::infinity());
  std::vector<int> before(free_.size(), -1);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  cost[static_cast<std::size_t>(from)] = 0;
  open.emplace(0.0, from);
  while (!open.empty()) {
    const auto [so_far, cell] = open.top();
    open.pop();
    if (cell == to) break;
    if (so_far > cost[static_cast<std::size_t>(cell)]) continue;
    for (const auto& [dx, dy] : kSteps) {
      const int x = cell % nx_ + dx, y = cell / nx_ + dy;
      if (x < 0 || x >= nx_ || y < 0 || y >= ny_) continue;
      const auto next = static_cast<std::size_t>(y * nx_ + x);
      const double there = so_far + std::hypot(dx, dy) * effort_[next];
      if (free_[next] == 0 || there >= cost[next]) continue;
      cost[next] = there;
      before[next] = cell;
      open.emplace(there, static_cast<int>(next));
    }
  }
  std::vector<int> way;
  if (std::isinf(cost[static_cast<std::size_t>(to)])) return way;
  for (int cell = to; cell >= 0; cell = before[static_cast<std::size_t>(cell)]) way.push_back(cell);
  std::ranges::reverse(way);
  return way;
}

void FreeFloor::KeepLargestPart() {
  std::vector<int> part_of(free_.size(), -1);
  std::vector<std::size_t> sizes;
  for (std::size_t first = 0; first < free_.size(); ++first) {
    if (free_[first] == 0 || part_of[first] >= 0) continue;
    const int part = static_cast<int>(sizes.size());
    sizes.push_back(0);
    std::vector<int> open = {static_cast<int>(first)};
    part_of[first] = part;
    while (!open.empty()) {
      const int cell = open.back();
      open.pop_back();
      ++sizes.back();
      const int x = cell % nx_, y = cell / nx_;
      for (const auto& [dx, dy] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
        if (x + dx < 0 || x + dx >= nx_ || y + dy < 0 || y + dy >= ny_) continue;
        const auto next = static_cast<std::size_t>((y + dy) * nx_ + x + dx);
        if (free_[next] == 0 || part_of[next] >= 0) continue;
        part_of[next] = part;
        open.push_back(static_cast<int>(next));
      }
    }
  }
  const auto largest = static_cast<int>(std::ranges::max_element(sizes) - sizes.begin());
  for (std::size_t n = 0; n < free_.size(); ++n) free_[n] = part_of[n] == largest ? 1 : 0;
}

}  // namespace deepslam::synth
