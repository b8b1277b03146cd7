// The parts of a layout as closed meshes for a scene.
#pragma once

#include <vector>

#include "deepslam/gltf/scene_writer.h"
#include "deepslam/scene/layout.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::presentation {

// Walls (`wall_03`) with holes where their openings are, the frames of doors, the panes of windows,
// floors and ceilings of rooms; each closed, and behind the face that was measured. Passages are
// holes: parts without a mesh. In the colours of `surface_world` where it shows the face of a wall,
// plain where it does not or has none.
[[nodiscard]] std::vector<gltf::GltfPart> LayoutParts(const Layout& layout_world,
                                                      const TriangleMesh& surface_world);

// The upper side of a floor among them: a centimetre below its level, and below the measured ground
// (z = 0) where the two are one floor, since faces in one plane would fight for every pixel.
[[nodiscard]] double TopOfFloor(double floor_m);

}  // namespace deepslam::presentation
