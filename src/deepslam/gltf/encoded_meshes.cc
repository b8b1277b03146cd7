#include "deepslam/gltf/encoded_meshes.h"

#include <algorithm>
#include <exception>
#include <functional>

#include "deepslam/gltf/check_scene.h"

namespace deepslam::gltf {

EncodedMeshes::EncodedMeshes(const std::vector<Wanted>& wanted) {
  for (const Wanted& mesh : wanted) entries_.push_back({mesh, {}});
  std::ranges::stable_sort(entries_, std::greater(), [](const Entry& entry) {
    return entry.wanted.source->faces.size();
  });
}

// What a library throws here it throws to the writer of the file again, which is left to say it.
void EncodedMeshes::Render(std::size_t n) {
  const Wanted& wanted = entries_[n].wanted;
  if (!CheckMeshInput(*wanted.source, "mesh").ok()) return;
  try {
    entries_[n].encoded = {MakeRenderMesh(*wanted.source, wanted.crease_angle_rad), {}};
  } catch (const std::exception&) {
    entries_[n].encoded.reset();
  }
}

void EncodedMeshes::Compress(std::size_t n, const GltfOptions& options) {
  std::optional<EncodedMesh>& encoded = entries_[n].encoded;
  if (!encoded || encoded->mesh.faces.empty()) return;
  try {
    encoded->draco = DracoEncode(
        encoded->mesh, options.position_bits, GltfOptions::kNormalBits, entries_[n].wanted.closed);
  } catch (const std::exception&) {
    encoded->draco.reset();
  }
}

const EncodedMesh* EncodedMeshes::Find(const TriangleMesh& source) const {
  const auto found = std::ranges::find_if(
      entries_, [&](const Entry& entry) { return entry.wanted.source == &source; });
  return found == entries_.end() || !found->encoded ? nullptr : &*found->encoded;
}

}  // namespace deepslam::gltf
