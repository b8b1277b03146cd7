// The finished map as a labelled scene: objects in their classes' or the measured colours, the seen
// floor, the room beside the objects and the camera's path.
#pragma once

#include "deepslam/geometry/camera.h"
#include "deepslam/gltf/scene_writer.h"
#include "deepslam/mesh/ground_polygon.h"
#include "deepslam/presentation/finished_map.h"
#include "deepslam/scene/object_class.h"

namespace deepslam::presentation {

struct SceneOptions {
  bool measured_colours = true;  // false: objects have their classes' colours alone
  bool room = true;
  bool trajectory = true;
  mesh::GroundPolygonOptions ground_polygon;
};

// `camera` is that of the keyframes. Objects without a surface stay without a mesh, and a floor
// that was never seen is left out.
[[nodiscard]] gltf::GltfScene MakeScene(const FinishedMap& finished,
                                        const ClassTable& classes,
                                        const PinholeCamera& camera,
                                        const RunIdentity& run,
                                        const SceneOptions& options);

}  // namespace deepslam::presentation
