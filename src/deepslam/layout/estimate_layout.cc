#include "deepslam/layout/estimate_layout.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "deepslam/layout/build_rooms.h"
#include "deepslam/layout/cell_complex.h"
#include "deepslam/layout/column_map.h"
#include "deepslam/layout/levels.h"
#include "deepslam/layout/select_lines.h"

namespace deepslam::layout {
namespace {

std::vector<double> FloorHeights(const std::vector<LayoutLevel>& levels) {
  std::vector<double> heights_m;
  for (const LayoutLevel& level : levels) {
    if (level.kind == LevelKind::kFloor) heights_m.push_back(level.height_m);
  }
  return heights_m;
}

// The ground, or what lies lowest but for a few stray points.
double LowestFloor(const CoarseSurface& surface, const std::vector<double>& floors_m) {
  if (!floors_m.empty()) return floors_m.front();
  if (surface.has_ground || surface.mesh.vertices.empty()) return 0;
  std::vector<float> heights;
  for (const Eigen::Vector3f& p : surface.mesh.vertices) heights.push_back(p.z());
  const auto low = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 50);
  std::nth_element(heights.begin(), low, heights.end());
  return static_cast<double>(*low);
}

}  // namespace

Layout EstimateLayout(const CoarseSurface& surface, const LayoutOptions& options) {
  BuiltLayout built;
  Layout& layout = built.layout;
  layout.level_from_tracking = surface.level_from_tracking;
  const std::vector<double> areas_m2 = VertexAreas(surface.mesh);
  const std::vector<SurfacePlane> planes = FindPlanes(surface, areas_m2, options.planes);
  layout.levels = FindLevels(surface, planes);
  layout.slanted = FindSlanted(planes);
  const std::vector<double> floors_m = FloorHeights(layout.levels);
  const double floor_m = LowestFloor(surface, floors_m);
  WallLines walls = SelectLines(
      surface, FindWallLines(surface, areas_m2, planes, options.lines), floor_m, options);
  if (walls.lines.empty()) {
    layout.notes.emplace_back("no walls were seen");
    return std::move(built.layout);
  }
  const ColumnMap columns = MapColumns(surface, floors_m);
  const CellComplex complex = CutGround(std::move(walls.lines), std::move(walls.profiles), columns);
  if (complex.lines.empty()) return std::move(built.layout);
  if (floors_m.empty()) {
    layout.notes.emplace_back("no floor was seen: walls are told, rooms are not");
  } else {
    AddRooms(surface, columns, complex, options, built);
  }
  AddLooseWalls(surface, complex, built);
  if (layout.walls.empty() && layout.notes.empty()) layout.notes.emplace_back("no walls were seen");
  AddOpenings(complex, built);
  return std::move(built.layout);
}

void Describe(OptionsVisitor& visitor, LayoutOptions& options) {
  visitor.Field(
      "min_wall_m", options.min_wall_m, {0.1, 10}, "m", "shorter walls are not looked for");
  visitor.Field("min_room_m2", options.min_room_m2, {0.1, 1000}, "m^2", "smaller rooms are none");
  visitor.Field(
      "align", options.align, "walls nearly at right angles are made so where most of them agree");
}

}  // namespace deepslam::layout
