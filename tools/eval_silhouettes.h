// `deepslam eval silhouettes`.
#pragma once

#include <string>

namespace deepslam::tools {

// A table for people on standard error, JSON to `json_file` (empty: standard output).
[[nodiscard]] int EvalSilhouettes(const std::string& workspace,
                                  const std::string& capture,
                                  const std::string& json_file);

}  // namespace deepslam::tools
