// The measured room as scenes and pictures show it beside the objects.
#pragma once

#include <optional>
#include <span>

#include "deepslam/scene/object_map.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::presentation {

inline constexpr double kRoomFloorBandM = 0.04;  // measured points this near to z = 0 are floor
inline constexpr double kObjectRimM = 0.05;  // depth this near to an object's mesh is the object's

inline constexpr double kWallRimM = 0.07;  // and this near to a part of the room itself, the part's

// `room_world` without what lies on the objects (`meshes` in their object frames, in the same
// order), on the ground polygon or on `parts_world` (walls, ceilings), and without the small
// components this leaves (mesh/floor_surface.h).
[[nodiscard]] TriangleMesh RoomBeside(const TriangleMesh& room_world,
                                      std::span<const MapObject> objects,
                                      std::span<const TriangleMesh> meshes,
                                      const std::optional<TriangleMesh>& ground,
                                      std::span<const TriangleMesh> parts_world = {});

}  // namespace deepslam::presentation
