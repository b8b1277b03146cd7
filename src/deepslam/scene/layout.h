// The room itself: rooms, walls, openings and levels of a capture.
//
// Level world unless a name says otherwise: z up, ground z = 0. Metres. Ids are positions in their
// lists, dense from 0.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "deepslam/geometry/plane.h"
#include "deepslam/geometry/pose.h"

namespace deepslam {

// A face of a wall, towards the room it bounds: walking from `from_m` to `to_m`, that room lies to
// the left.
struct LayoutWall {
  Eigen::Vector2d from_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d to_m = Eigen::Vector2d::Zero();
  double bottom_m = 0;
  double top_m = 0;        // the ceiling, or as high as the wall was seen where none was
  std::vector<int> rooms;  // whose it is; none: a wall whose room was not closed
  double seen_share = 0;   // of its length, where its surface was measured; the rest is hidden or
                           // was never looked at
  double confidence = 0;   // [0, 1]
  double offset_sigma_m = 0;   // standard deviations of the line: across it at its middle,
  double angle_sigma_rad = 0;  // and of its direction

  [[nodiscard]] double length_m() const { return (to_m - from_m).norm(); }
  friend bool operator==(const LayoutWall&, const LayoutWall&) = default;
};

enum class OpeningKind { kDoor, kWindow, kPassage };
[[nodiscard]] std::string_view NameOf(OpeningKind kind);  // door, window, passage

// How wide and how high doors of homes are: 0.6 to 1.3 m wide, two-winged ones included, 1.8 to 2.3
// m high (DIN 18101 has 0.6 to 1.25 and 1.98 to 2.11, other countries a little more); a cell of 5
// cm is added on either side, as measuring adds it. What is wider and reaches the floor is a
// passage.
inline constexpr double kNarrowDoor_m = 0.55;
inline constexpr double kWidestDoor_m = 1.35;   // 1.3 and a cell
inline constexpr double kWidestLeaf_m = 1.05;   // of one leaf (DIN 18101: 0.985), with a cell
inline constexpr double kLowestDoor_m = 1.75;   // 1.8 less a cell
inline constexpr double kHighestDoor_m = 2.35;  // 2.3 and a cell

// A rectangle of a wall's face.
struct LayoutOpening {
  int wall = 0;
  OpeningKind kind = OpeningKind::kDoor;
  Eigen::Vector2d from_m = Eigen::Vector2d::Zero();  // on the wall, in its direction
  Eigen::Vector2d to_m = Eigen::Vector2d::Zero();
  double bottom_m = 0;
  double top_m = 0;
  std::vector<int> rooms;  // it joins; the one of its wall first
  double confidence = 0;   // [0, 1]; below 0.5 is doubtful
  std::string note;        // what is doubtful about it; empty: nothing
  friend bool operator==(const LayoutOpening&, const LayoutOpening&) = default;
};

struct LayoutRoom {
  // Corners counter-clockwise, seen from above; the edge behind corner i leads to corner i + 1.
  std::vector<Eigen::Vector2d> polygon_m;
  std::vector<bool> guessed;  // per edge: closed where nothing was seen
  double floor_m = 0;
  double ceiling_m = 0;   // 0: not seen
  double seen_share = 0;  // of its area, floor, ceiling or free space above what stands there
  double confidence = 0;  // [0, 1]
  std::string note;       // what is doubtful about it; empty: nothing
  friend bool operator==(const LayoutRoom&, const LayoutRoom&) = default;
};

[[nodiscard]] double AreaOf(
    const std::vector<Eigen::Vector2d>& polygon_m);  // > 0 counter-clockwise
[[nodiscard]] bool IsInside(const std::vector<Eigen::Vector2d>& polygon_m,
                            const Eigen::Vector2d& point);

enum class LevelKind { kFloor, kCeiling };

// A horizontal plane: the ground, a step or gallery, a ceiling.
struct LayoutLevel {
  LevelKind kind = LevelKind::kFloor;
  double height_m = 0;
  double area_m2 = 0;  // seen
  friend bool operator==(const LayoutLevel&, const LayoutLevel&) = default;
};

// A large plane that neither stands nor lies: the slope of a roof, a ramp. No wall, no ceiling.
struct SlantedPlane {
  Plane plane;  // normal to the free side
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double area_m2 = 0;
  friend bool operator==(const SlantedPlane&, const SlantedPlane&) = default;
};

struct Layout {
  std::vector<LayoutRoom> rooms;
  std::vector<LayoutWall> walls;
  std::vector<LayoutOpening> openings;
  std::vector<LayoutLevel> levels;    // floors by height, then ceilings by height
  std::vector<SlantedPlane> slanted;  // by area, largest first
  Pose3 level_from_tracking;
  std::vector<std::string> notes;  // why something is left out, in plain words
  friend bool operator==(const Layout&, const Layout&) = default;
};

}  // namespace deepslam
