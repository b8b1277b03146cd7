#include "deepslam/presentation/room_beside.h"

#include <cstddef>
#include <vector>

#include "deepslam/fuse/canonical_mesh.h"
#include "deepslam/mesh/floor_surface.h"

namespace deepslam::presentation {
namespace {

// Smaller pieces of the room that hang in the air once floor and objects are gone are small
// components, left out.
constexpr int kMinPieceFaces = 50;

}  // namespace

TriangleMesh RoomBeside(const TriangleMesh& room_world,
                        std::span<const MapObject> objects,
                        std::span<const TriangleMesh> meshes,
                        const std::optional<TriangleMesh>& ground,
                        std::span<const TriangleMesh> parts_world) {
  std::vector<TriangleMesh> placed(meshes.begin(), meshes.end());
  for (std::size_t i = 0; i < placed.size(); ++i) {
    for (Eigen::Vector3f& p : placed[i].vertices)
      p = (objects[i].world_from_object * p.cast<double>()).cast<float>();
  }
  TriangleMesh room = mesh::WithoutObjects(room_world, placed, kObjectRimM, kRoomFloorBandM);
  if (!parts_world.empty())
    room = mesh::WithoutObjects(room, parts_world, kWallRimM, kRoomFloorBandM);
  if (ground) room = mesh::WithoutFloor(room, *ground, kRoomFloorBandM);
  return fuse::CanonicalMesh(fuse::WithoutSmallComponents(room, kMinPieceFaces));
}

}  // namespace deepslam::presentation
