// The surface of a volume at a level (Lorensen, Cline 1987).
#pragma once

#include "deepslam/eval/volume.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::eval {

// Vertices are interpolated along the grid's edges, in units of samples; larger values are inside.
// Faces of cells with two diagonal corners inside are settled by the bilinear value in their middle
// (asymptotic decider), so that the surface has no cracks; it ends at the volume's border. Faces
// counter-clockwise from outside.
[[nodiscard]] TriangleMesh MarchingCubes(const Volume& volume, float level);

}  // namespace deepslam::eval
