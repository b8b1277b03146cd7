#include "deepslam/synth/home_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace deepslam::synth {
namespace {

constexpr double kPartition_m = 0.1;     // as plasterboard partitions have it
constexpr double kSmallestSide_m = 2.1;  // of a room
constexpr double kDoor_m = 0.9;          // clear width, common in homes
constexpr double kDoorFromCorner_m = 0.12;   // room for its frame
constexpr double kWindowFromCorner_m = 0.4;  // of windows and the home's closed door
constexpr double kWindowReach_m = 0.5;  // where nothing high stands; doors: twice, nothing at all
constexpr double kDoorHeight_m = 2.05;  // of the gap, common in homes

// A partition across one axis: constant along it, from low to high along the other.
struct Cut {
  int axis = 0;
  double at_m = 0;
  double low_m = 0, high_m = 0;
};

// Halves the largest room that is large enough, again and again.
std::vector<FloorRectangle> Divide(const FloorRectangle& whole,
                                   std::size_t num_rooms,
                                   Random& random,
                                   std::vector<Cut>& cuts) {
  std::vector<FloorRectangle> rooms = {whole};
  while (rooms.size() < num_rooms) {
    const auto largest = std::ranges::max_element(rooms, {}, &FloorRectangle::area_m2);
    const FloorRectangle room = *largest;
    const int axis = room.size().x() >= room.size().y() ? 0 : 1;
    const double length_m = room.size()[axis];
    if (length_m < 2 * kSmallestSide_m + kPartition_m) break;
    const double share = random.Uniform(0.38, 0.62);
    const double at_m = room.min[axis] + std::clamp(share * length_m,
                                                    kSmallestSide_m + kPartition_m / 2,
                                                    length_m - kSmallestSide_m - kPartition_m / 2);
    // Partitions meet in the middle of their thickness.
    cuts.push_back({axis, at_m, room.min[1 - axis], room.max[1 - axis]});
    FloorRectangle low = room, high = room;
    low.max[axis] = at_m - kPartition_m / 2;
    high.min[axis] = at_m + kPartition_m / 2;
    *largest = low;
    rooms.push_back(high);
  }
  return rooms;
}

std::vector<PlannedRoom> NameRooms(const std::vector<FloorRectangle>& floors) {
  std::vector<PlannedRoom> rooms;
  for (const FloorRectangle& floor : floors) rooms.push_back({RoomUse::kBedroom, floor});
  std::vector<std::size_t> by_area(rooms.size());
  std::iota(by_area.begin(), by_area.end(), std::size_t{0});
  std::ranges::stable_sort(
      by_area, std::greater(), [&](std::size_t n) { return rooms[n].floor.area_m2(); });
  rooms[by_area[0]].use = RoomUse::kLiving;
  if (rooms.size() > 1) rooms[by_area[1]].use = RoomUse::kKitchen;
  if (rooms.size() > 3) rooms[by_area.back()].use = RoomUse::kBath;
  return rooms;
}

// Where two rooms face each other across a cut: along the cut, from low to high.
struct Shared {
  std::size_t low_room = 0, high_room = 0;
  double low_m = 0, high_m = 0;
};

std::vector<Shared> SharedAcross(const Cut& cut, const std::vector<PlannedRoom>& rooms) {
  std::vector<Shared> shared;
  for (std::size_t a = 0; a < rooms.size(); ++a) {
    for (std::size_t b = 0; b < rooms.size(); ++b) {
      const FloorRectangle &low = rooms[a].floor, &high = rooms[b].floor;
      if (std::abs(low.max[cut.axis] - (cut.at_m - kPartition_m / 2)) > 1e-6 ||
          std::abs(high.min[cut.axis] - (cut.at_m + kPartition_m / 2)) > 1e-6)
        continue;
      const int along = 1 - cut.axis;
      const double from = std::max({low.min[along], high.min[along], cut.low_m});
      const double to = std::min({low.max[along], high.max[along], cut.high_m});
      if (to - from > kDoor_m + 2 * kDoorFromCorner_m) shared.push_back({a, b, from, to});
    }
  }
  return shared;
}

int RootOf(std::vector<int>& joined, int room) {
  while (joined[static_cast<std::size_t>(room)] != room)
    room = joined[static_cast<std::size_t>(room)];
  return room;
}

// One door wherever it joins what was not joined.
void AddPartition(const Cut& cut, Random& random, std::vector<int>& joined, HomePlan& plan) {
  const int along = 1 - cut.axis;
  ScenePartition partition;
  partition.thickness_m = kPartition_m;
  partition.from_m[cut.axis] = partition.to_m[cut.axis] = cut.at_m;
  partition.from_m[along] = cut.low_m - kPartition_m / 2;
  partition.to_m[along] = cut.high_m + kPartition_m / 2;
  // Outer walls end it.
  const Eigen::Vector2d half = plan.size_m.head<2>() / 2;
  partition.from_m = partition.from_m.cwiseMax(-half).cwiseMin(half);
  partition.to_m = partition.to_m.cwiseMax(-half).cwiseMin(half);
  for (const Shared& shared : SharedAcross(cut, plan.rooms)) {
    const int low = RootOf(joined, static_cast<int>(shared.low_room));
    const int high = RootOf(joined, static_cast<int>(shared.high_room));
    if (low == high) continue;
    joined[static_cast<std::size_t>(high)] = low;
    const double left_m = random.Uniform(shared.low_m + kDoorFromCorner_m,
                                         shared.high_m - kDoorFromCorner_m - kDoor_m);
    SceneOpening gap;
    gap.from_m = left_m - partition.from_m[along];
    gap.width_m = kDoor_m;
    gap.height_m = kDoorHeight_m;
    partition.openings.push_back(gap);
    PlannedDoor door;
    door.middle_m[cut.axis] = cut.at_m;
    door.middle_m[along] = left_m + kDoor_m / 2;
    door.through = Eigen::Vector2d::Unit(cut.axis);
    door.from = static_cast<int>(shared.low_room);
    door.to = static_cast<int>(shared.high_room);
    plan.doors.push_back(door);
  }
  plan.partitions.push_back(partition);
}

// The outer walls: axis across, and on which side of the home.
struct OuterSide {
  int axis;
  double side;
};
constexpr std::array<OuterSide, 4> kOuter = {{{0, 1}, {1, 1}, {0, -1}, {1, -1}}};

// A window in a room's outer wall, or the home's closed door.
void AddOuterOpening(int wall, std::size_t room, bool is_door, Random& random, HomePlan& plan) {
  const auto& [axis, side] = kOuter[static_cast<std::size_t>(wall)];
  const int along = 1 - axis;
  const FloorRectangle& floor = plan.rooms[room].floor;
  const double low_m = floor.min[along] + kWindowFromCorner_m;
  const double high_m = floor.max[along] - kWindowFromCorner_m;
  SceneOpening opening;
  opening.wall = wall;
  opening.closed = is_door;
  opening.width_m = is_door ? kDoor_m : std::min(random.Uniform(0.9, 1.6), high_m - low_m);
  if (high_m - low_m < opening.width_m + 1e-6) return;
  const double start_m = random.Uniform(low_m, high_m - opening.width_m);
  opening.bottom_m = is_door ? 0 : random.Uniform(0.8, 1.0);
  opening.height_m = is_door ? kDoorHeight_m : random.Uniform(1.0, 1.3);
  // A wall's left end, seen from inside: east and south run down, north and west up.
  const double half_m = plan.size_m[along] / 2;
  const bool downwards = wall == 0 || wall == 3;
  opening.from_m = downwards ? half_m - start_m - opening.width_m : start_m + half_m;
  plan.openings.push_back(opening);
  PlannedWindow window;
  window.room = static_cast<int>(room);
  window.reach.min[along] = start_m;
  window.reach.max[along] = start_m + opening.width_m;
  const double wall_m = side * plan.size_m[axis] / 2;
  const double reach_m = is_door ? 2 * kWindowReach_m : kWindowReach_m;
  window.reach.min[axis] = std::min(wall_m, wall_m - side * reach_m);
  window.reach.max[axis] = std::max(wall_m, wall_m - side * reach_m);
  plan.windows.push_back(window);
}

void AddOuterOpenings(Random& random, HomePlan& plan) {
  bool has_door = false;
  for (std::size_t room = 0; room < plan.rooms.size(); ++room) {
    bool has_window = false;
    for (int wall = 0; wall < 4; ++wall) {
      const auto& [axis, side] = kOuter[static_cast<std::size_t>(wall)];
      const FloorRectangle& floor = plan.rooms[room].floor;
      const double at_m = side > 0 ? floor.max[axis] : floor.min[axis];
      if (std::abs(at_m - side * plan.size_m[axis] / 2) > 1e-6) continue;
      if (!has_window && plan.rooms[room].use != RoomUse::kBath) {
        AddOuterOpening(wall, room, false, random, plan);
        has_window = true;
      } else if (!has_door && plan.rooms[room].use == RoomUse::kLiving) {
        AddOuterOpening(wall, room, true, random, plan);
        has_door = true;
      }
    }
  }
}

}  // namespace

HomePlan PlanHome(Random& random) {
  HomePlan plan;
  const std::size_t num_rooms = 3 + static_cast<std::size_t>(random.Index(3));
  const double area_m2 = 14.0 * static_cast<double>(num_rooms);
  const double ratio = random.Uniform(1.1, 1.5);
  plan.size_m = {std::sqrt(area_m2 * ratio), std::sqrt(area_m2 / ratio), random.Uniform(2.4, 2.8)};
  const Eigen::Vector2d half = plan.size_m.head<2>() / 2;
  std::vector<Cut> cuts;
  plan.rooms = NameRooms(Divide({-half, half}, num_rooms, random, cuts));
  std::vector<int> joined(plan.rooms.size());
  std::iota(joined.begin(), joined.end(), 0);
  for (const Cut& cut : cuts) AddPartition(cut, random, joined, plan);
  AddOuterOpenings(random, plan);
  return plan;
}

}  // namespace deepslam::synth
