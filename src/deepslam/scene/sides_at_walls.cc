#include "deepslam/scene/sides_at_walls.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "deepslam/core/angles.h"
#include "deepslam/scene/wall_geometry.h"

namespace deepslam {
namespace {

constexpr double kParallelRad = 20 * kRadPerDeg;  // measured yaws are good to a few degrees
// Skirting boards and the reach of open doors keep furniture off walls by a few centimetres, and
// what was not seen of its back is missing of its box.
constexpr double kNear_m = 0.15;
constexpr double kMinOverlap = 0.5;  // of the side's length, which is not beside the wall's end
// Beside a wall, with the back in the room: half as unlikely as facing the wall.
constexpr double kBesideWall = 0.5;

// Farther through a wall no error of a layout or of a size brings a thing.
constexpr double kMostThrough_m = 0.3;

struct BoxSide {
  Eigen::Vector2d outward = Eigen::Vector2d::UnitX();
  Eigen::Vector2d middle_m = Eigen::Vector2d::Zero();
  double length_m = 0;
};

BoxSide SideOf(const Pose3& level_from_box, const Eigen::Vector3d& size_m, int side) {
  const bool along_x = side % 2 == 0;
  const double sign = side < 2 ? 1 : -1;
  const Eigen::Vector3d axis = along_x ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  const Eigen::Vector2d outward = sign * (level_from_box.rotation * axis).head<2>();
  const double half_m = 0.5 * (along_x ? size_m.x() : size_m.y());
  return {outward,
          level_from_box.translation_m.head<2>() + half_m * outward,
          along_x ? size_m.y() : size_m.x()};
}

bool StandsAt(const LayoutWall& wall, const Pose3& level_from_box, const BoxSide& side) {
  const Eigen::Vector2d along = AlongOf(wall);
  const Eigen::Vector2d into_room(-along.y(), along.x());
  if (!(side.outward.dot(into_room) <= -std::cos(kParallelRad))) return false;
  const Eigen::Vector3d& centre_m = level_from_box.translation_m;
  if (centre_m.z() < wall.bottom_m || centre_m.z() > wall.top_m) return false;
  const Eigen::Vector2d opposite_m = 2 * centre_m.head<2>() - side.middle_m;
  if (!(DistanceBefore(wall, opposite_m) > 0)) return false;
  // What reaches through the wall stands at it all the more.
  if (!(DistanceBefore(wall, side.middle_m) <= kNear_m)) return false;
  const double middle_m = along.dot(side.middle_m - wall.from_m);
  const double first_m = std::max(0.0, middle_m - 0.5 * side.length_m);
  const double last_m = std::min(wall.length_m(), middle_m + 0.5 * side.length_m);
  return last_m - first_m >= kMinOverlap * side.length_m;
}

// Of each side how far it is before the wall it stands at, negative where it reaches through; of
// several the least. Nothing where it stands at none.
std::array<std::optional<double>, 4> BeforeWalls(const Layout& layout,
                                                 const Pose3& level_from_box,
                                                 const Eigen::Vector3d& size_m) {
  std::array<std::optional<double>, 4> before_m;
  for (int n = 0; n < 4; ++n) {
    const BoxSide side = SideOf(level_from_box, size_m, n);
    std::optional<double>& least_m = before_m[static_cast<std::size_t>(n)];
    for (const LayoutWall& wall : layout.walls) {
      if (!(wall.length_m() > 0) || !StandsAt(wall, level_from_box, side)) continue;
      const double wall_m = DistanceBefore(wall, side.middle_m);
      least_m = std::min(wall_m, least_m.value_or(wall_m));
    }
  }
  return before_m;
}

SidesAtWalls AtWalls(const std::array<std::optional<double>, 4>& before_m) {
  SidesAtWalls at_walls = {};
  std::ranges::transform(before_m, at_walls.begin(), [](const auto& m) { return m.has_value(); });
  return at_walls;
}

// The box of a model, given in its own frame, where the model stands.
struct StandingBox {
  Pose3 level_from_box;
  Eigen::Vector3d size_m;

  StandingBox(const Layout& layout,
              const Similarity3& tracking_from_object,
              const Eigen::AlignedBox3f& box_object)
      : level_from_box(
            layout.level_from_tracking *
            Pose3(tracking_from_object.rotation,
                  tracking_from_object * Eigen::Vector3d(box_object.center().cast<double>()))),
        size_m(tracking_from_object.scale * box_object.sizes().cast<double>()) {}
};

}  // namespace

SidesAtWalls FindSidesAtWalls(const Layout& layout,
                              const Pose3& level_from_box,
                              const Eigen::Vector3d& size_m) {
  return AtWalls(BeforeWalls(layout, level_from_box, size_m));
}

double FrontBlocked(const SidesAtWalls& at_walls, int side) {
  const auto at = [&](int n) { return at_walls[static_cast<std::size_t>(n % 4)]; };
  if (at(side + 2)) return 0;
  if (at(side)) return 1;
  return at(side + 1) || at(side + 3) ? kBesideWall : 0;
}

double FrontBlocked(const Layout& layout,
                    const Similarity3& tracking_from_object,
                    const Eigen::AlignedBox3f& box_object) {
  if (box_object.isEmpty()) return 0;
  const StandingBox box(layout, tracking_from_object, box_object);
  return FrontBlocked(FindSidesAtWalls(layout, box.level_from_box, box.size_m), 0);
}

double WallConflict(const Layout& layout,
                    const Pose3& level_from_box,
                    const Eigen::Vector3d& size_m) {
  const std::array<std::optional<double>, 4> before_m = BeforeWalls(layout, level_from_box, size_m);
  const bool is_through = std::ranges::any_of(
      before_m, [](const std::optional<double>& m) { return m && *m < -kMostThrough_m; });
  return is_through ? 1 : FrontBlocked(AtWalls(before_m), 0);
}

double WallConflict(const Layout& layout,
                    const Similarity3& tracking_from_object,
                    const Eigen::AlignedBox3f& box_object) {
  if (box_object.isEmpty()) return 0;
  const StandingBox box(layout, tracking_from_object, box_object);
  return WallConflict(layout, box.level_from_box, box.size_m);
}

}  // namespace deepslam
