// The finished map as a labelled scene: objects in their classes' or the measured colours, the seen
// floor, the room itself, what else of it was measured beside the objects, and the camera's path.
#pragma once

#include "deepslam/geometry/camera.h"
#include "deepslam/gltf/scene_writer.h"
#include "deepslam/mesh/ground_polygon.h"
#include "deepslam/presentation/finished_map.h"
#include "deepslam/scene/object_class.h"

namespace deepslam::presentation {

// What stands around the objects: the room itself as its layout has it, its measured surface, or
// both, the surface then without what the layout stands for. Where nothing of a layout is known,
// the measured surface.
enum class Surroundings { kLayout, kMeasured, kBoth };

struct SceneOptions {
  bool measured_colours = true;  // false: objects have their classes' colours alone
  bool room = true;              // the measured surface, where `surroundings` has it
  bool trajectory = true;
  mesh::GroundPolygonOptions ground_polygon;
  Surroundings surroundings = Surroundings::kBoth;
};

// `camera` is that of the keyframes. Objects without a surface stay without a mesh, and a floor
// that was never seen is left out.
[[nodiscard]] gltf::GltfScene MakeScene(const FinishedMap& finished,
                                        const ClassTable& classes,
                                        const PinholeCamera& camera,
                                        const RunIdentity& run,
                                        const SceneOptions& options);

}  // namespace deepslam::presentation
