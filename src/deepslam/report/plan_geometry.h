// What a floor plan shows of walls and doors, in metres of the map's world, for whatever draws it
// (plan_walls.h, plan_dxf.h).
#pragma once

#include <array>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "deepslam/report/floor_plan.h"
#include "deepslam/scene/layout.h"

namespace deepslam::report {

// A point of a wall: along it from its beginning, before its face (behind it: negative).
class WallFrame {
 public:
  explicit WallFrame(const LayoutWall& wall);

  [[nodiscard]] Eigen::Vector2d At(double along_m, double before_m) const {
    return from_m_ + along_m * along_ + before_m * inward_;
  }
  [[nodiscard]] const Eigen::Vector2d& along() const { return along_; }

 private:
  Eigen::Vector2d from_m_;
  Eigen::Vector2d along_;
  Eigen::Vector2d inward_;
};

// As measured, or an inner wall's usual one where the other face was not seen.
[[nodiscard]] double DrawnThickness(const Layout& layout, const LayoutWall& wall);

// Where the wall's body begins and ends along it: longer than its face in hollow corners.
[[nodiscard]] std::pair<double, double> BodyOf(const Layout& layout, const LayoutWall& wall);

// The part [span.first, span.second] of a wall's body, over its thickness; counter-clockwise from
// the face's beginning.
[[nodiscard]] std::array<Eigen::Vector2d, 4> BodyOutline(const Layout& layout,
                                                         const LayoutWall& wall,
                                                         const std::pair<double, double>& span);

// Of the body, what openings of this wall and of its other face leave, in order.
[[nodiscard]] std::vector<std::pair<double, double>> SolidSpans(const Layout& layout,
                                                                const LayoutWall& wall);

// Sides of rooms, or parts of them, that no wall stands on: they were guessed or not seen.
using PlanLine = std::pair<Eigen::Vector2d, Eigen::Vector2d>;
[[nodiscard]] std::vector<PlanLine> UnseenSides(const Layout& layout);

// Hung at the end that is nearer to the wall's, open by a right angle into the room.
struct DoorLeaf {
  Eigen::Vector2d hinge_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d latch_m = Eigen::Vector2d::Zero();  // where it shuts
  Eigen::Vector2d open_m = Eigen::Vector2d::Zero();   // its free end
  double width_m = 0;
  bool shuts_clockwise = false;  // from open to shut, seen from above
};
[[nodiscard]] DoorLeaf LeafOf(const LayoutWall& wall, const std::pair<double, double>& span);

using PlanQuad = std::array<Eigen::Vector2d, 4>;

// The square that the leaf of each door goes over a part of.
[[nodiscard]] std::vector<PlanQuad> DoorSwings(const Layout& layout);

// What is in the way of a room's name: furniture and the leaves of doors.
[[nodiscard]] std::vector<PlanQuad> ObstaclesOf(const FloorPlanContent& content);

// The place in a room that is farthest from its walls and from what is in the way.
[[nodiscard]] Eigen::Vector2d FreePlace(const LayoutRoom& room,
                                        const std::vector<PlanQuad>& obstacles);

}  // namespace deepslam::report
