// Draco compression of triangle meshes as glTF's KHR_draco_mesh_compression has it.
//
// Positions are quantised on a cubic grid over the bounding box with 2^bits points along its
// longest side: each coordinate of a decoded vertex lies within QuantisationError() of the source.
// Vertices at equal places stay at equal places and those at different places stay apart, so a
// closed mesh stays closed; where the grid is too coarse for that it is refined.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/result.h"
#include "deepslam/gltf/render_mesh.h"

namespace deepslam::gltf {

inline constexpr int kMinPositionBits = 6;   // 64 steps, as the models' grid has
inline constexpr int kMaxPositionBits = 20;  // a micrometre for each metre: no capture is as exact

// Largest difference per coordinate between vertices and their copies decoded from a grid of so
// many bits, in their unit.
[[nodiscard]] double QuantisationError(const std::vector<Eigen::Vector3f>& positions,
                                       int position_bits);

// Bytes, and what a decoder will get out of them.
struct DracoPayload {
  std::string bytes;
  RenderMesh decoded;     // order of vertices and faces is Draco's
  int position_bits = 0;  // those taken in the end
  int position_id = -1;   // Draco's unique ids of the attributes; -1 = absent
  int normal_id = -1;
  int colour_id = -1;
};

// Positions, normals, colours (lossless) and faces. Without `keep_apart` the grid is as asked for
// even where vertices fall together (open surfaces, which have nothing to lose by it). Bits in
// [kMinPositionBits, kMaxPositionBits]. Errors: empty mesh, index out of range, not finite, two
// corners of a face at one place, no grid fine enough.
[[nodiscard]] Result<DracoPayload> DracoEncode(const RenderMesh& mesh,
                                               int position_bits,
                                               int normal_bits,
                                               bool keep_apart = true);

}  // namespace deepslam::gltf
