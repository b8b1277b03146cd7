#include "deepslam/synth/home_walk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "deepslam/synth/camera_path.h"
#include "deepslam/synth/free_floor.h"

namespace deepslam::synth {
namespace {

constexpr double kEye_m = 1.5;           // height of the camera, held before the face
constexpr double kTarget_m = 0.55;       // height looked at: furniture and some floor
constexpr double kSpeed_m_per_s = 0.45;  // half of walking, so that pictures stay sharp
constexpr double kTurn_rad_per_s = 0.8;  // of a view that is to stay sharp
constexpr double kTurnedAt = 0.5;        // of the way to where one looks next
constexpr double kFramesPerS = 10;       // 4.5 cm apart at that speed
// Through a door one looks where one goes: from so far before it, to so far behind it.
constexpr double kBeforeDoor_m = 0.9;
constexpr double kBehindDoor_m = 2;          // far enough to look through, not at the leaf
constexpr double kPointEvery_m = 0.5;        // along the way; the curve smooths corners within
constexpr double kCornerShare = 0.6;         // of the way from a room's middle to its corner
constexpr std::size_t kMaxWayPoints = 1000;  // as a scene's file may have (scene_table.cc)

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
    StopNear(door.middle_m - kBeforeDoor_m * along, plan_.rooms[from].floor, door.middle_m);
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

// The short way round.
double ShortTurn(double from_rad, double to_rad) {
  return std::remainder(to_rad - from_rad, 2 * std::numbers::pi);
}

// How far one sees before the walls of one's room.
double OpenBefore_m(const HomePlan& plan, const Eigen::Vector2d& at, double yaw_rad) {
  constexpr double kInDoor_m = 4;  // through it, into the next room
  const Eigen::Vector2d view(std::cos(yaw_rad), std::sin(yaw_rad));
  for (const PlannedRoom& room : plan.rooms) {
    if (!room.floor.Contains({at, at})) continue;
    double open_m = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 2; ++axis) {
      const double edge = view[axis] > 0 ? room.floor.max[axis] : room.floor.min[axis];
      if (std::abs(view[axis]) > 1e-9) open_m = std::min(open_m, (edge - at[axis]) / view[axis]);
    }
    return open_m;
  }
  return kInDoor_m;
}

// The least of it in a turn.
double OpenInTurn_m(const HomePlan& plan, const Eigen::Vector2d& at, double from_rad, double turn) {
  constexpr int kNumLooks = 12;  // 30 degrees apart in a full turn
  double open_m = std::numeric_limits<double>::infinity();
  for (int k = 0; k <= kNumLooks; ++k)
    open_m = std::min(open_m, OpenBefore_m(plan, at, from_rad + k * turn / kNumLooks));
  return open_m;
}

// The short way round, or the long one where that shows the room and the short one a wall from
// near.
double OpenTurn(const HomePlan& plan, const Eigen::Vector2d& at, double from_rad, double to_rad) {
  constexpr double kNearWall_m = 1.2;  // a wall this near fills the picture
  const double short_rad = ShortTurn(from_rad, to_rad);
  const double long_rad = short_rad - std::copysign(2 * std::numbers::pi, short_rad);
  const double open_m = OpenInTurn_m(plan, at, from_rad, short_rad);
  const bool is_long = open_m < kNearWall_m && OpenInTurn_m(plan, at, from_rad, long_rad) > open_m;
  return is_long ? long_rad : short_rad;
}

// Points of a walk one after the other; where the view turns far between two, it turns by steps
// before the camera goes on.
class Filming {
 public:
  Filming(const HomePlan& plan, SceneWalk& walk) : plan_(plan), walk_(walk) {}

  [[nodiscard]] double yaw_rad() const { return yaw_rad_; }

  void Begin(const Eigen::Vector2d& at, double yaw_rad) {
    at_ = at;
    yaw_rad_ = yaw_rad;
    AddPoint();
  }

  void GoOn(const Eigen::Vector2d& at, double yaw_rad) {
    const double turn_rad = yaw_rad - yaw_rad_;
    const int num_steps =
        std::max(1, static_cast<int>(std::ceil(std::abs(turn_rad) / kTurnStep_rad)));
    for (int k = 1; k < num_steps; ++k) {
      yaw_rad_ += turn_rad / num_steps;
      AddPoint();
    }
    Begin(at, yaw_rad);
  }

 private:
  static constexpr double kTurnStep_rad = 0.4;  // 23 degrees: pictures overlap by half and more
  // As far ahead as the wall, at what stands before it: near walls one looks down, and across a
  // room so that walls are seen to above the doors.
  static constexpr double kNearestTarget_m = 1.8;
  static constexpr double kFarthestTarget_m =
      4;  // farther targets would show more ceiling than floor

  void AddPoint() {
    walk_.points_m.emplace_back(at_.x(), at_.y(), kEye_m);
    const double ahead_m =
        std::clamp(OpenBefore_m(plan_, at_, yaw_rad_), kNearestTarget_m, kFarthestTarget_m);
    walk_.look_at_m.emplace_back(
        at_.x() + ahead_m * std::cos(yaw_rad_), at_.y() + ahead_m * std::sin(yaw_rad_), kTarget_m);
  }

  const HomePlan& plan_;
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
  const int stride = static_cast<int>(kPointEvery_m / FreeFloor::kCell_m);
  Filming filming(plan, walk);
  std::optional<int> last;
  for (const Stop& stop : stops) {
    if (!last) {
      const Eigen::Vector2d at = floor.PlaceOf(stop.cell);
      filming.Begin(at, YawTo(at, stop.look_at_m));
      last = stop.cell;
      continue;
    }
    const double before_rad = filming.yaw_rad();
    const Eigen::Vector2d before = floor.PlaceOf(*last);
    double turn_rad = OpenTurn(plan, before, before_rad, YawTo(before, stop.look_at_m));
    const std::vector<int> way = floor.Way(*last, stop.cell);
    if (way.empty() || walk.points_m.size() + way.size() > kMaxWayPoints) continue;
    for (std::size_t k = 1; k < way.size(); ++k) {
      const bool is_last = k + 1 == way.size();
      if (!is_last && k % static_cast<std::size_t>(stride) != 0) continue;
      // The view turns from one target to the next in the first part of the way.
      const double share =
          std::min(1.0, static_cast<double>(k) / (kTurnedAt * static_cast<double>(way.size() - 1)));
      const Eigen::Vector2d at = floor.PlaceOf(way[k]);
      turn_rad += ShortTurn(before_rad + turn_rad, YawTo(at, stop.look_at_m));
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
