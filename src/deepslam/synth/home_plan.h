// The floor plan of a made-up home: rooms, the partitions between them, doors and windows.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/random.h"
#include "deepslam/synth/scene_description.h"

namespace deepslam::synth {

// A rectangle on the floor, metres.
struct FloorRectangle {
  Eigen::Vector2d min = Eigen::Vector2d::Zero();
  Eigen::Vector2d max = Eigen::Vector2d::Zero();

  [[nodiscard]] Eigen::Vector2d middle() const { return (min + max) / 2; }
  [[nodiscard]] Eigen::Vector2d size() const { return max - min; }
  [[nodiscard]] double area_m2() const { return size().prod(); }
  [[nodiscard]] bool Overlaps(const FloorRectangle& other, double margin_m = 0) const {
    return (min.array() < other.max.array() + margin_m).all() &&
           (max.array() > other.min.array() - margin_m).all();
  }
  [[nodiscard]] bool Contains(const FloorRectangle& other) const {
    return (min.array() <= other.min.array()).all() && (max.array() >= other.max.array()).all();
  }
};

enum class RoomUse { kLiving, kKitchen, kBedroom, kBath };

struct PlannedRoom {
  RoomUse use = RoomUse::kLiving;
  FloorRectangle floor;  // between the faces of its walls
};

struct PlannedDoor {
  Eigen::Vector2d middle_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d through = Eigen::Vector2d::UnitX();  // unit vector from one room to the other
  int from = 0, to = 0;                                // rooms
};

struct PlannedWindow {
  int room = 0;
  FloorRectangle reach;  // what stands here stands before it
};

struct HomePlan {
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  std::vector<PlannedRoom> rooms;
  std::vector<PlannedDoor> doors;  // every room can be reached
  std::vector<PlannedWindow> windows;
  std::vector<ScenePartition> partitions;
  std::vector<SceneOpening> openings;  // of the outer walls: windows, and a closed door
};

// Three to five rooms; the largest is the living room, the smallest of four or more the bath.
[[nodiscard]] HomePlan PlanHome(Random& random);

}  // namespace deepslam::synth
