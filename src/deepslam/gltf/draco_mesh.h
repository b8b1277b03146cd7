// Draco compression of triangle meshes.
//
// Positions are quantised on a cubic grid over the bounding box with 2^bits points along its
// longest side: each coordinate of a decoded vertex lies within QuantisationError() of the source.
// Vertices at equal places stay at equal places and those at different places stay apart, so a
// closed mesh stays closed; where the grid is too coarse for that it is refined.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/result.h"
#include "deepslam/gltf/render_mesh.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::gltf {

inline constexpr int kMinPositionBits = 6;
inline constexpr int kMaxPositionBits = 20;

// Largest difference per coordinate between a mesh and its copy decoded from a grid of so many
// bits, in the mesh's unit.
[[nodiscard]] double QuantisationError(const TriangleMesh& mesh, int position_bits);

// Positions, faces and, where the mesh has them, colours (lossless). Bits in [kMinPositionBits,
// kMaxPositionBits]. Errors: empty mesh, index out of range, not finite, two corners of a face at
// one place, no grid fine enough.
[[nodiscard]] Result<std::string> DracoEncode(const TriangleMesh& mesh, int position_bits);

// The mesh of DracoEncode; order of vertices and faces is Draco's. Any other bytes give an error,
// and nothing large is allocated for short input.
[[nodiscard]] Result<TriangleMesh> DracoDecode(std::string_view bytes);

// For KHR_draco_mesh_compression: bytes, and what a decoder will get out of them. Without
// `keep_apart` the grid is as asked for even where vertices fall together (open surfaces, which
// have nothing to lose by it).
struct DracoPayload {
  std::string bytes;
  RenderMesh decoded;
  int position_bits = 0;  // those taken in the end
  int position_id = -1;   // Draco's unique ids of the attributes; -1 = absent
  int normal_id = -1;
  int colour_id = -1;
};
[[nodiscard]] Result<DracoPayload> DracoEncodeForGltf(const RenderMesh& mesh,
                                                      int position_bits,
                                                      int normal_bits,
                                                      bool keep_apart = true);
// Attributes by unique id, -1 = none. Never trusts the payload's counts.
[[nodiscard]] Result<RenderMesh> DracoDecodeForGltf(std::string_view bytes,
                                                    int position_id,
                                                    int normal_id,
                                                    int colour_id);

// Any program's mesh, for reading furniture: attributes by unique id, -1 = none.
struct DracoAttributeIds {
  int position = -1;
  int place = -1;
  int colour = -1;
};
struct DracoModel {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector2f> places;   // in the texture; empty: none, or not of two numbers
  std::vector<Eigen::Vector3f> colours;  // integers brought to [0, 1]; empty: none
  std::vector<std::array<std::uint32_t, 3>> faces;
};
[[nodiscard]] Result<DracoModel> DracoDecodeModel(std::string_view bytes,
                                                  const DracoAttributeIds& ids);

}  // namespace deepslam::gltf
