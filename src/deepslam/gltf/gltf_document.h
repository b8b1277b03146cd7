// A glTF opened: the shell of a GLB or the text of a .gltf, its JSON and its own bytes.
#pragma once

#include <optional>
#include <string_view>

#include "deepslam/gltf/findings.h"
#include "deepslam/gltf/json_place.h"

namespace deepslam::gltf {

struct GltfDocument {
  GltfJson json;
  std::string_view binary;  // of a GLB, its BIN chunk

  [[nodiscard]] JsonPlace root() const { return json.root(); }
};

// Nothing where the shell or the JSON cannot be read. Other versions of glTF than 2 are an error as
// well. `bytes` and `findings` have to outlive the document.
[[nodiscard]] std::optional<GltfDocument> OpenGlb(std::string_view bytes, Findings& findings);
[[nodiscard]] std::optional<GltfDocument> OpenGlbOrGltf(std::string_view bytes, Findings& findings);

}  // namespace deepslam::gltf
