// The scene graph of a map.
#pragma once

#include <span>

#include "deepslam/scene/compact_map.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/scene/scene_graph.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::presentation {

// `meshes` and `volumes_m3` have one entry per object of the map, in its order; meshes in the
// metric object frame, empty: without a surface. Poses, sizes and the layout are those of the map;
// other places are rounded as its are.
[[nodiscard]] SceneGraph MakeSceneGraph(const CompactMap& map,
                                        std::span<const TriangleMesh> meshes,
                                        std::span<const double> volumes_m3,
                                        const ClassTable& classes);

}  // namespace deepslam::presentation
