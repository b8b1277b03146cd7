// The outer shell of a GLB: header and chunks.
#pragma once

#include <optional>
#include <string_view>

#include "deepslam/gltf/findings.h"

namespace deepslam::gltf {

// Views into the file's bytes.
struct GlbChunks {
  std::string_view json;
  std::string_view binary;  // empty: the file has no BIN chunk
};

// Nothing when it is no GLB, truncated or damaged; `findings` says where.
[[nodiscard]] std::optional<GlbChunks> ReadGlbChunks(std::string_view bytes, Findings& findings);

}  // namespace deepslam::gltf
