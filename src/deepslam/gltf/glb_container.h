// The outer shell of a GLB: header and chunks.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "deepslam/gltf/gltf_document.h"

namespace deepslam::gltf {

// Views into the file's bytes.
struct GlbChunks {
  std::string_view json;
  std::string_view binary;  // empty: the file has no BIN chunk
};

// Nothing when it is no GLB, truncated or damaged; `findings` says where.
[[nodiscard]] std::optional<GlbChunks> ReadGlbChunks(std::string_view bytes, Findings& findings);

// What is wrong with the nesting of a JSON text: parsers go down into it recursively. Empty =
// nothing.
[[nodiscard]] std::string NestingFault(std::string_view json);

}  // namespace deepslam::gltf
