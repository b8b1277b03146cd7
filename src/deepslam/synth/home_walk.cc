#include "deepslam/synth/home_walk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>
#include <queue>
#include <utility>

#include "deepslam/synth/camera_path.h"

namespace deepslam::synth {
namespace {

constexpr double kCell_m = 0.1;
constexpr double kClearance_m = 0.28;  // between the camera and what stands there or walls
// Where there is room, people stay so far from walls, as if the way along them were so many times
// as long.
constexpr double kComfort_m = 0.55;
constexpr double kDiscomfort = 3;
constexpr double kEye_m = 1.5;
constexpr double kTarget_m = 0.55;
constexpr double kSpeed_m_per_s = 0.45;
constexpr double kTurn_rad_per_s = 0.8;  // of a view that is to stay sharp
constexpr double kFramesPerS = 10;
// Through a door one looks where one goes: from so far before it, to so far behind it.
constexpr double kBeforeDoor_m = 0.9;
constexpr double kBehindDoor_m = 2;
constexpr double kPointEvery_m = 0.5;
constexpr double kCornerShare = 0.6;  // of the way from a room's middle to its corner
constexpr std::size_t kMaxPoints = 1000;

// Where one can walk, in cells.
class FreeFloor {
 public:
  FreeFloor(const HomePlan& plan, const std::vector<FloorRectangle>& taken)
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

  [[nodiscard]] Eigen::Vector2d PlaceOf(int cell) const {
    return {-half_.x() + (cell % nx_ + 0.5) * kCell_m, -half_.y() + (cell / nx_ + 0.5) * kCell_m};
  }

  // The free cell of a rectangle that is nearest to a place.
  [[nodiscard]] std::optional<int> Nearest(const Eigen::Vector2d& place,
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

  // Cells from one to another, both included; none where no way leads there.
  [[nodiscard]] std::vector<int> Way(int from, int to) const {
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
    for (int cell = to; cell >= 0; cell = before[static_cast<std::size_t>(cell)])
      way.push_back(cell);
    std::ranges::reverse(way);
    return way;
  }

 private:
  // What cannot be walked to from most of the home is no place to stand.
  void KeepLargestPart() {
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

  static bool IsFree(const HomePlan& plan,
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

  Eigen::Vector2d half_;
  int nx_, ny_;
  std::vector<std::uint8_t> free_;
  std::vector<double> effort_;  // as many times as long as on open floor
};

struct Stop {
  int cell = 0;
  Eigen::Vector2d look_at_m = Eigen::Vector2d::Zero();
};

class Tour {
 public:
  Tour(const HomePlan& plan, const FreeFloor& floor)
      : plan_(plan), floor_(floor), visited_(plan.rooms.size(), false) {}

  std::vector<Stop> Take() {
    VisitRoom(0, plan_.rooms[0].floor.min);
    return std::move(stops_);
  }

 private:
  // From corner to corner, the one next to where one comes in first, looking at the one across.
  void VisitRoom(std::size_t n, const Eigen::Vector2d& entry) {
    visited_[n] = true;
    const FloorRectangle& room = plan_.rooms[n].floor;
    const Eigen::Vector2d middle = room.middle();
    const std::array<Eigen::Vector2d, 4> corners = {room.min,
                                                    Eigen::Vector2d(room.max.x(), room.min.y()),
                                                    room.max,
                                                    Eigen::Vector2d(room.min.x(), room.max.y())};
    std::size_t first = 0;
    for (std::size_t k = 1; k < corners.size(); ++k) {
      if ((corners[k] - entry).norm() < (corners[first] - entry).norm()) first = k;
    }
    for (std::size_t k = 0; k <= corners.size(); ++k) {
      const Eigen::Vector2d& corner = corners[(first + k) % corners.size()];
      const Eigen::Vector2d from = middle + kCornerShare * (corner - middle);
      StopNear(from, room, middle - 0.8 * (corner - middle));
    }
    for (const PlannedDoor& door : plan_.doors) {
      if (door.from != static_cast<int>(n) && door.to != static_cast<int>(n)) continue;
      const auto other =
          static_cast<std::size_t>(door.from == static_cast<int>(n) ? door.to : door.from);
      if (visited_[other]) continue;
      Through(door, n, other);
      VisitRoom(other, door.middle_m);
      Through(door, other, n);
    }
  }

  // Before the door, in it and behind it, looking along the way.
  void Through(const PlannedDoor& door, std::size_t from, std::size_t to) {
    const Eigen::Vector2d towards = plan_.rooms[to].floor.middle() - door.middle_m;
    const Eigen::Vector2d along = towards.dot(door.through) > 0 ? door.through : -door.through;
    const Eigen::Vector2d look_at_m = door.middle_m + kBehindDoor_m * along;
    StopNear(door.middle_m - kBeforeDoor_m * along, plan_.rooms[from].floor, look_at_m);
    StopNear(door.middle_m, {door.middle_m.array() - 0.3, door.middle_m.array() + 0.3}, look_at_m);
    StopNear(door.middle_m + kBeforeDoor_m * along, plan_.rooms[to].floor, look_at_m);
  }

  void StopNear(const Eigen::Vector2d& place,
                const FloorRectangle& within,
                const Eigen::Vector2d& look_at_m) {
    if (const std::optional<int> cell = floor_.Nearest(place, within))
      stops_.push_back({*cell, look_at_m});
  }

  const HomePlan& plan_;
  const FreeFloor& floor_;
  std::vector<bool> visited_;
  std::vector<Stop> stops_;
};

// Points of a walk one after the other; where the view turns far between two, it turns by steps
// before the camera goes on.
class Filming {
 public:
  explicit Filming(SceneWalk& walk) : walk_(walk) {}

  [[nodiscard]] double yaw_rad() const { return yaw_rad_; }

  void Begin(const Eigen::Vector2d& at, double yaw_rad) {
    at_ = at;
    yaw_rad_ = yaw_rad;
    AddPoint();
  }

  void GoOn(const Eigen::Vector2d& at, double yaw_rad) {
    const double turn_rad = Turn(yaw_rad_, yaw_rad);
    const int num_steps = std::max(1, static_cast<int>(std::ceil(std::abs(turn_rad) / kStep_rad)));
    for (int k = 1; k < num_steps; ++k) {
      yaw_rad_ += turn_rad / num_steps;
      AddPoint();
    }
    Begin(at, yaw_rad);
  }

  // The short way round.
  static double Turn(double from_rad, double to_rad) {
    return std::remainder(to_rad - from_rad, 2 * std::numbers::pi);
  }

 private:
  static constexpr double kStep_rad = 0.4;
  static constexpr double kLook_m = 1.8;  // ahead, on the floor

  void AddPoint() {
    walk_.points_m.emplace_back(at_.x(), at_.y(), kEye_m);
    walk_.look_at_m.emplace_back(
        at_.x() + kLook_m * std::cos(yaw_rad_), at_.y() + kLook_m * std::sin(yaw_rad_), kTarget_m);
  }

  SceneWalk& walk_;
  Eigen::Vector2d at_ = Eigen::Vector2d::Zero();
  double yaw_rad_ = 0;
};

double YawTo(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  return std::atan2(to.y() - from.y(), to.x() - from.x());
}

}  // namespace

void AddWalk(const HomePlan& plan,
             const std::vector<FloorRectangle>& taken,
             SceneDescription& scene) {
  const FreeFloor floor(plan, taken);
  const std::vector<Stop> stops = Tour(plan, floor).Take();
  SceneWalk& walk = scene.walk;
  walk.turn_m_per_rad = kSpeed_m_per_s / kTurn_rad_per_s;
  const int stride = static_cast<int>(kPointEvery_m / kCell_m);
  Filming filming(walk);
  std::optional<int> last;
  for (const Stop& stop : stops) {
    if (!last) {
      const Eigen::Vector2d at = floor.PlaceOf(stop.cell);
      filming.Begin(at, YawTo(at, stop.look_at_m));
      last = stop.cell;
      continue;
    }
    const double before_rad = filming.yaw_rad();
    const std::vector<int> way = floor.Way(*last, stop.cell);
    if (way.empty() || walk.points_m.size() + way.size() > kMaxPoints) continue;
    for (std::size_t k = 1; k < way.size(); ++k) {
      const bool is_last = k + 1 == way.size();
      if (!is_last && k % static_cast<std::size_t>(stride) != 0) continue;
      // The view turns from one target to the next on the way.
      const double share = static_cast<double>(k) / static_cast<double>(way.size() - 1);
      const Eigen::Vector2d at = floor.PlaceOf(way[k]);
      const double turn_rad = Filming::Turn(before_rad, YawTo(at, stop.look_at_m));
      filming.GoOn(at, before_rad + share * turn_rad);
    }
    last = stop.cell;
  }
  if (walk.points_m.size() == 1) {  // a way has two ends
    walk.points_m.push_back(walk.points_m.front() + Eigen::Vector3d(0.01, 0, 0));
    walk.look_at_m.push_back(walk.look_at_m.front());
  }
  scene.frames_per_s = kFramesPerS;
  scene.num_frames =
      std::max(2, static_cast<int>(WalkLength_m(walk) / kSpeed_m_per_s * kFramesPerS));
}

}  // namespace deepslam::synth
