// The room's measured surface beside what a scene shows in its place.
//
// The floor is there twice over: as the ground polygon, and in the room's surface. In one plane the
// two would fight for every pixel, so a scene shows the polygon, in the colours of the surface, and
// the surface without what the polygon stands for. Objects likewise.
#pragma once

#include <span>

#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::mesh {

// Both meshes in the world, z up, floor at z = 0; `ground_polygon` as mesh::GroundPolygon gives it.

// The room without its faces on the floor: level, within `band_m` of z = 0, and over the polygon
// (touching it is enough). What then is left within the band as rags of its own, mostly over the
// polygon, goes as well. Floor beside the polygon stays. Vertices keep their places in the list.
[[nodiscard]] TriangleMesh WithoutFloor(const TriangleMesh& room_world,
                                        const TriangleMesh& ground_polygon,
                                        double band_m);

// The polygon with vertices every `step_m` inside (fewer on floors so large that they would be more
// than 40,000), each in the mean colour of the room's vertices within `band_m` of the floor and
// about `step_m` of it; where none is, under furniture, in what lies around it. The outline stays
// the same. Comes back as it is when the room has no colours on the floor, or step_m is 0.
[[nodiscard]] TriangleMesh ColouredGround(const TriangleMesh& ground_polygon,
                                          const TriangleMesh& room_world,
                                          double band_m,
                                          double step_m);

// The room without its faces that lie within `distance_m` of an object's surface, each corner of
// some object's: the rims of objects that segmentation left to the room, which would lie about the
// object's mesh in rags. Level faces within `floor_band_m` of z = 0 stay, objects stand on them.
// `objects_world` are meshes in the world; empty ones are passed over.
[[nodiscard]] TriangleMesh WithoutObjects(const TriangleMesh& room_world,
                                          std::span<const TriangleMesh> objects_world,
                                          double distance_m,
                                          double floor_band_m);

}  // namespace deepslam::mesh
