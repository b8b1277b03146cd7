#include "deepslam/presentation/layout_parts.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "deepslam/mesh/slab.h"
#include "deepslam/scene/wall_geometry.h"

namespace deepslam::presentation {
namespace {

constexpr double kSlabThickness_m = 0.06;  // of slabs; walls are thicker, but this is what was seen
constexpr double kLeastThickness_m = 0.005;  // thinner slabs' faces fight for pixels at a distance
constexpr double kDoorFrame_m = 0.06;        // width of a door's frame
constexpr double kFrameDepth_m = 0.02;       // it stands out of the wall by so much
constexpr double kPane_m = 0.02;             // thickness of a window's glass with its sashes
constexpr double kUnderGround_m = 0.01;      // from a floor's level to its upper side
constexpr double kSameFloor_m = 0.05;  // from the ground: a floor's own error, not another storey
constexpr double kCeilingOpacity = 0.25;  // rooms are looked into from above
constexpr double kGlassOpacity = 0.35;    // seen through, and yet seen
constexpr Rgb8 kWallColour{226, 222, 214};
constexpr Rgb8 kFloorColour{190, 180, 166};
constexpr Rgb8 kCeilingColour{240, 240, 238};
constexpr Rgb8 kDoorColour{150, 116, 84};
constexpr Rgb8 kGlassColour{150, 190, 215};

// x along the wall from its beginning, y into its room, z up.
Pose3 WorldFromWall(const LayoutWall& wall) {
  const Eigen::Vector2d along = AlongOf(wall);
  const double angle = std::atan2(along.y(), along.x());
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ())),
          {wall.from_m.x(), wall.from_m.y(), 0}};
}

// Half of what lies between this face and the one behind it, at most kSlabThickness_m.
double SlabThickness(const Layout& layout, const LayoutWall& wall) {
  constexpr double kLessThanHalf = 0.48;  // two slabs that touched would be one mesh to no one
  const double wall_m = ThicknessOf(layout, wall).value_or(kThickestWall_m);
  return std::max(kLeastThickness_m, std::min(kSlabThickness_m, kLessThanHalf * wall_m));
}

TriangleMesh Placed(TriangleMesh mesh, const Pose3& world_from_mesh) {
  for (Eigen::Vector3f& p : mesh.vertices) p = (world_from_mesh * p.cast<double>()).cast<float>();
  return mesh;
}

gltf::GltfPart PartOf(std::string_view kind, std::size_t id) {
  gltf::GltfPart part;
  part.kind = kind;
  part.id = static_cast<int>(id);
  part.name = fmt::format("{}_{:02}", kind, id);
  return part;
}

class PartMaker {
 public:
  PartMaker(const Layout& layout, const TriangleMesh& surface)
      : layout_(layout), surface_(surface) {}

  [[nodiscard]] std::vector<gltf::GltfPart> Make() && {
    for (std::size_t n = 0; n < layout_.walls.size(); ++n) AddWall(n);
    for (std::size_t n = 0; n < layout_.openings.size(); ++n) AddOpening(n);
    for (std::size_t n = 0; n < layout_.rooms.size(); ++n) AddRoom(n);
    return std::move(parts_);
  }

 private:
  void AddWall(std::size_t number) {
    const LayoutWall& wall = layout_.walls[number];
    gltf::GltfPart part = PartOf("wall", number);
    part.rooms = wall.rooms;
    part.figures = {{"length_m", wall.length_m()},
                    {"height_m", wall.top_m - wall.bottom_m},
                    {"seen_share", wall.seen_share},
                    {"confidence", wall.confidence}};
    part.colour = kWallColour;
    const double thickness_m = SlabThickness(layout_, wall);
    mesh::SlabColours colours;
    mesh::Slab slab;
    slab.left_m = MeetsInHollowCorner(layout_, wall, false) ? -thickness_m : 0;
    slab.right_m = wall.length_m() + (MeetsInHollowCorner(layout_, wall, true) ? thickness_m : 0);
    slab.bottom_m = wall.bottom_m;
    slab.top_m = wall.top_m;
    slab.thickness_m = thickness_m;
    slab.step_m = surface_.colours.empty() ? slab.right_m - slab.left_m + slab.top_m - slab.bottom_m
                                           : colours.step_m;
    for (const LayoutOpening& opening : layout_.openings) {
      if (opening.wall != static_cast<int>(number) && !GoesThrough(layout_, opening, wall))
        continue;
      const auto [left_m, right_m] = SpanOf(opening, wall);
      slab.holes.push_back({left_m, right_m, opening.bottom_m, opening.top_m});
    }
    part.mesh_world = mesh::MakeSlab(slab);
    mesh::ColourSlab(surface_, WorldFromWall(wall), colours, part.mesh_world);
    part.mesh_world = Placed(std::move(part.mesh_world), WorldFromWall(wall));
    parts_.push_back(std::move(part));
  }

  void AddOpening(std::size_t number) {
    const LayoutOpening& opening = layout_.openings[number];
    const LayoutWall& wall = layout_.walls[static_cast<std::size_t>(opening.wall)];
    gltf::GltfPart part = PartOf(NameOf(opening.kind), number);
    part.rooms = opening.rooms;
    part.wall = opening.wall;
    part.figures = {{"width_m", (opening.to_m - opening.from_m).norm()},
                    {"height_m", opening.top_m - opening.bottom_m},
                    {"confidence", opening.confidence}};
    const auto [left_m, right_m] = SpanOf(opening, wall);
    const double thickness_m = SlabThickness(layout_, wall);
    mesh::Slab slab{left_m, right_m, opening.bottom_m, opening.top_m, kPane_m, {}, 1e3};
    double before_m = 0;
    if (opening.kind == OpeningKind::kWindow) {
      part.colour = kGlassColour;
      part.opacity = kGlassOpacity;
      before_m = -0.5 * (thickness_m - kPane_m);
    } else if (opening.kind == OpeningKind::kDoor) {
      part.colour = kDoorColour;
      // The frame alone: leaves stand open or closed, and rooms are walked through.
      slab.thickness_m = thickness_m + 2 * kFrameDepth_m;
      slab.holes = {{left_m + kDoorFrame_m,
                     right_m - kDoorFrame_m,
                     opening.bottom_m - 1,
                     opening.top_m - kDoorFrame_m}};
      before_m = kFrameDepth_m;
    }
    if (opening.kind != OpeningKind::kPassage) {
      Pose3 place = WorldFromWall(wall);
      place.translation_m = place * Eigen::Vector3d(0, before_m, 0);
      part.mesh_world = Placed(mesh::MakeSlab(slab), place);
    }
    parts_.push_back(std::move(part));
  }

  void AddPrism(gltf::GltfPart part,
                const std::vector<Eigen::Vector2d>& polygon_m,
                double bottom_m) {
    // An outline that crosses itself has no inside: the room then goes without.
    Result<TriangleMesh> prism = mesh::MakePrism(polygon_m, kSlabThickness_m);
    if (!prism.ok()) return;
    part.mesh_world =
        Placed(std::move(prism).value(), {Eigen::Quaterniond::Identity(), {0, 0, bottom_m}});
    parts_.push_back(std::move(part));
  }

  void AddRoom(std::size_t number) {
    const LayoutRoom& room = layout_.rooms[number];
    gltf::GltfPart floor = PartOf("floor", number);
    floor.rooms = {static_cast<int>(number)};
    floor.figures = {{"area_m2", AreaOf(room.polygon_m)}, {"height_m", room.floor_m}};
    floor.colour = kFloorColour;
    AddPrism(std::move(floor), room.polygon_m, TopOfFloor(room.floor_m) - kSlabThickness_m);
    if (!HasCeiling(room)) return;
    gltf::GltfPart ceiling = PartOf("ceiling", number);
    ceiling.rooms = {static_cast<int>(number)};
    ceiling.figures = {{"area_m2", AreaOf(room.polygon_m)}, {"height_m", room.ceiling_m}};
    ceiling.colour = kCeilingColour;
    ceiling.opacity = kCeilingOpacity;
    AddPrism(std::move(ceiling), room.polygon_m, room.ceiling_m);
  }

  const Layout& layout_;
  const TriangleMesh& surface_;
  std::vector<gltf::GltfPart> parts_;
};

}  // namespace

double TopOfFloor(double floor_m) {
  const double level_m = std::abs(floor_m) < kSameFloor_m ? std::min(floor_m, 0.0) : floor_m;
  return level_m - kUnderGround_m;
}

std::vector<gltf::GltfPart> LayoutParts(const Layout& layout_world,
                                        const TriangleMesh& surface_world) {
  return PartMaker(layout_world, surface_world).Make();
}

}  // namespace deepslam::presentation
