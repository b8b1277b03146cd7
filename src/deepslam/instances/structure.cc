#include "deepslam/instances/structure.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "deepslam/core/parallel.h"
#include "deepslam/instances/wall_axes.h"

namespace deepslam::instances {
namespace {

constexpr float kUpward = 0.9F;  // z of a normal that faces up: within 26 degrees
constexpr double kAlikeNormals =
    0.7;                             // cosine: within 45 degrees, as fused normals of walls scatter
constexpr double kEndSlackM = 0.08;  // walls go on to their corners
constexpr double kSlantedM = 0.08;   // a slanted plane is found within this

bool IsOfWall(const LayoutWall& wall,
              const Eigen::Vector3d& p,
              const Eigen::Vector3d& normal,
              const StructureOptions& options) {
  if (p.z() < wall.bottom_m - kEndSlackM || p.z() > wall.top_m + kEndSlackM) return false;
  const std::optional<WallAxes> axes = AxesOf(wall);
  if (!axes) return false;
  const OnWall place = axes->Place(p.head<2>());
  if (place.along_m < -kEndSlackM || place.along_m > wall.length_m() + kEndSlackM) return false;
  if (place.before_m > options.wall_m || place.before_m < -options.behind_wall_m) return false;
  return place.before_m < 0 || axes->inward.dot(normal.head<2>()) > kAlikeNormals;
}

bool IsOfOpening(const LayoutOpening& opening,
                 const LayoutWall& wall,
                 const Eigen::Vector3d& p,
                 double leaf_m) {
  if (p.z() < opening.bottom_m - kEndSlackM || p.z() > opening.top_m + kEndSlackM) return false;
  const std::optional<WallAxes> axes = AxesOf(wall);
  if (!axes) return false;
  const OnWall place = axes->Place(p.head<2>());
  if (std::abs(place.before_m) > leaf_m) return false;
  const double from_m = axes->Place(opening.from_m).along_m;
  const double to_m = axes->Place(opening.to_m).along_m;
  return place.along_m > std::min(from_m, to_m) - kEndSlackM &&
         place.along_m < std::max(from_m, to_m) + kEndSlackM;
}

bool IsOfLevels(const Layout& layout,
                const Eigen::Vector3d& p,
                double up,
                const StructureOptions& options) {
  const auto is_floor = [&](double above_m) {
    return above_m < options.floor_m || (above_m < options.carpet_m && up > kUpward);
  };
  if (is_floor(p.z())) return true;
  return std::ranges::any_of(layout.levels, [&](const LayoutLevel& level) {
    if (level.kind == LevelKind::kCeiling) return p.z() > level.height_m - options.ceiling_m;
    const double above_m = p.z() - level.height_m;
    return above_m > -options.floor_m && is_floor(above_m) && up > kAlikeNormals;
  });
}

}  // namespace

void Describe(OptionsVisitor& visitor, StructureOptions& options) {
  visitor.Field(
      "floor_m", options.floor_m, {0, 0.5}, "m", "surface this near above a floor is the floor");
  visitor.Field("carpet_m",
                options.carpet_m,
                {0, 0.5},
                "m",
                "so is surface that faces up this near above it");
  visitor.Field("ceiling_m",
                options.ceiling_m,
                {0, 1},
                "m",
                "surface this near below a ceiling is the ceiling");
  visitor.Field("wall_m",
                options.wall_m,
                {0, 0.5},
                "m",
                "surface this near before a wall, facing as it does, is the wall");
  visitor.Field("behind_wall_m",
                options.behind_wall_m,
                {0, 1},
                "m",
                "surface this far behind a wall's face is the wall");
  visitor.Field(
      "leaf_m", options.leaf_m, {0, 1}, "m", "surface this near to a door or window belongs to it");
}

std::vector<char> StructureElements(const SurfaceElements& elements,
                                    const Layout& layout,
                                    const StructureOptions& options) {
  std::vector<char> is_structure(elements.size(), 0);
  ParallelFor(elements.size(), [&](std::size_t i) {
    const Eigen::Vector3d p = elements.points()[i].cast<double>();
    const Eigen::Vector3d normal = elements.normals()[i].cast<double>();
    const bool is_part =
        IsOfLevels(layout, p, normal.z(), options) ||
        std::ranges::any_of(
            layout.walls,
            [&](const LayoutWall& wall) { return IsOfWall(wall, p, normal, options); }) ||
        std::ranges::any_of(layout.openings,
                            [&](const LayoutOpening& opening) {
                              const LayoutWall& wall =
                                  layout.walls[static_cast<std::size_t>(opening.wall)];
                              return IsOfOpening(opening, wall, p, options.leaf_m);
                            }) ||
        std::ranges::any_of(layout.slanted, [&](const SlantedPlane& slanted) {
          return std::abs(slanted.plane.SignedDistance(p)) < kSlantedM;
        });
    is_structure[i] = is_part ? 1 : 0;
  });
  return is_structure;
}

}  // namespace deepslam::instances
