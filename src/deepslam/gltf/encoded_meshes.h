// The meshes of a scene as its files hold them, made once for all files.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/gltf/draco_encode.h"
#include "deepslam/gltf/render_mesh.h"
#include "deepslam/gltf/scene_writer.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::gltf {

struct EncodedMesh {
  RenderMesh mesh;
  std::optional<Result<DracoPayload>> draco;  // nothing: not compressed yet
};

// Two calls for different meshes may run side by side. The largest comes first.
class EncodedMeshes {
 public:
  struct Wanted {
    const TriangleMesh* source = nullptr;  // has to stay where it is
    double crease_angle_rad = 0;
    bool closed = true;
  };

  explicit EncodedMeshes(const std::vector<Wanted>& wanted);

  [[nodiscard]] std::size_t size() const { return entries_.size(); }
  // As a mesh of glTF. Left out where the mesh is not valid (see CheckMeshInput).
  void Render(std::size_t n);
  // After Render; a mesh without faces is left as it is.
  void Compress(std::size_t n, const GltfOptions& options);
  // Nothing where it was not wanted or is not valid.
  [[nodiscard]] const EncodedMesh* Find(const TriangleMesh& source) const;

 private:
  struct Entry {
    Wanted wanted;
    std::optional<EncodedMesh> encoded;
  };
  std::vector<Entry> entries_;
};

}  // namespace deepslam::gltf
