#pragma once

#include <string>
#include <string_view>

#include "command_tree.h"

namespace deepslam::tools {

// deepslam(1), in the macros of man(7).
[[nodiscard]] std::string ManPage(const CommandNode& root, std::string_view version);

}  // namespace deepslam::tools
