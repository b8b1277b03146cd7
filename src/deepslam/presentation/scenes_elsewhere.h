// A labelled scene as other programs have it: Universal Scene Description, and simulators.
#pragma once

#include "deepslam/gltf/scene_writer.h"
#include "deepslam/presentation/rigid_bodies.h"
#include "deepslam/scene/compact_map.h"
#include "deepslam/simulator/simulator_scene.h"
#include "deepslam/usd/usd_scene.h"

namespace deepslam::presentation {

// Groups Objects, Layout (walls, openings, floors and ceilings) and Surroundings (the seen floor
// and the measured room). `bodies` may be null: the scene has no physics then. Poses are those of
// `map`, whose objects are the scene's.
[[nodiscard]] usd::UsdScene UsdSceneOf(const gltf::GltfScene& scene,
                                       const CompactMap& map,
                                       const RigidBodies* bodies);

// Objects and parts; surroundings are nothing that collides. An object without a surface is left
// out. The floor is the ground of the map, without end.
[[nodiscard]] simulator::SimulatorScene SimulatorSceneOf(const gltf::GltfScene& scene,
                                                         const CompactMap& map,
                                                         const RigidBodies& bodies);

}  // namespace deepslam::presentation
