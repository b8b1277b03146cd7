// What physics engines have to know of the things of a map.
#pragma once

#include <span>
#include <vector>

#include "deepslam/convex/decompose.h"
#include "deepslam/gltf/scene_writer.h"
#include "deepslam/scene/compact_map.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/shape/rigid_body.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::presentation {

struct RigidBodies {
  std::vector<RigidBody> objects;  // one per object of the map, in its order; metric object frame
  std::vector<RigidBody> parts;    // one per part of the room itself; world
};

// Every surface as convex pieces. Masses go by the classes' densities. An object is free where it
// stands on the floor or on another, its class is not fixed to the building, and it would not tip
// over: everything else stays where it is.
//
// Measured things neither end at the floor nor apart from one another, and engines throw apart what
// overlaps. So the pieces alone, never the meshes that are seen, are moved down or up to the floor
// of free objects that stand on it, made flat where they end within a band above it (of 1 to 10 cm,
// the lowest on which the object stands), and cut where they reach into those of another object, a
// wall.
[[nodiscard]] RigidBodies MakeRigidBodies(const CompactMap& map,
                                          std::span<const TriangleMesh> meshes,
                                          std::span<const gltf::GltfPart> parts,
                                          const ClassTable& classes,
                                          const convex::DecomposeOptions& options);

}  // namespace deepslam::presentation
