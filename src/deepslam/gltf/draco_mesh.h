// Draco compression of triangle meshes.
//
// Positions are quantised on a cubic grid over the bounding box with 2^bits points along its
// longest side: each coordinate of a decoded vertex lies within QuantisationError() of the source.
// Vertices at equal positions stay equal, so a closed mesh stays closed; faces that the grid makes
// degenerate are an error, never silently dropped.
#pragma once

#include <string>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::gltf {

// Largest difference per coordinate between a mesh and its decoded copy, in the mesh's unit.
[[nodiscard]] double QuantisationError(const TriangleMesh& mesh, int position_bits);

// Positions, faces and, where the mesh has them, colours (lossless). position_bits in [8, 20].
// Errors: empty mesh, index out of range, not finite, too coarse a grid.
[[nodiscard]] Result<std::string> DracoEncode(const TriangleMesh& mesh, int position_bits);

// The mesh of DracoEncode; order of vertices and faces is Draco's. Any other bytes give an error,
// and nothing large is allocated for short input.
[[nodiscard]] Result<TriangleMesh> DracoDecode(std::string_view bytes);

}  // namespace deepslam::gltf
