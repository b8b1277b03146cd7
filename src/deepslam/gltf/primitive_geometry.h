// The triangles, lines or points of one primitive of a glTF, plain or compressed by Draco.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "deepslam/gltf/gltf_buffers.h"
#include "deepslam/gltf/json_place.h"

namespace deepslam::gltf {

inline constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";

// primitive.mode.
inline constexpr std::uint64_t kTriangles = 4;
// Every further corner makes a face with the two before it.
inline constexpr std::uint64_t kTriangleStrip = 5;
// Every further corner makes a face with the last and the first.
inline constexpr std::uint64_t kTriangleFan = 6;

struct GeometryWanted {
  int texture_set = -1;  // of the places in textures; -1: none are wanted
  bool colours = false;
  // All that Draco holds has to be sound, used or not, and positions and normals floats.
  bool strict = false;
  std::size_t max_faces = std::numeric_limits<std::uint32_t>::max();  // of a primitive
};

struct PrimitiveGeometry {
  std::vector<Eigen::Vector3f> positions;  // the node's frame, not looked at: may be not finite
  std::vector<Eigen::Vector2f> places;     // as glTF has them, v downwards; or empty
  std::vector<Eigen::Vector3f> colours;    // linear, without alpha; or empty
  std::vector<std::uint32_t> corners;      // in the primitive's mode; they name positions
  bool is_compressed = false;              // the corners are those of triangles
};

// The extension's place; nothing is there where the primitive is a plain one.
[[nodiscard]] JsonPlace DracoOf(const JsonPlace& primitive);

// Nothing, and an error, where an accessor it needs is missing, damaged or of the wrong type.
[[nodiscard]] std::optional<PrimitiveGeometry> ReadPrimitive(GltfBuffers& buffers,
                                                             const JsonPlace& primitive,
                                                             const GeometryWanted& wanted);

}  // namespace deepslam::gltf
