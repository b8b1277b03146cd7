#pragma once

#include <map>
#include <string>
#include <vector>

#include "command_tree.h"

namespace deepslam::tools {

// Options of the stages by name ("track.poses"), with all values where these are few: what may
// stand after --set.
using SettingWords = std::map<std::string, std::vector<std::string>>;

[[nodiscard]] std::string BashCompletion(const CommandNode& root, const SettingWords& settings);
[[nodiscard]] std::string ZshCompletion(const CommandNode& root, const SettingWords& settings);
[[nodiscard]] std::string FishCompletion(const CommandNode& root, const SettingWords& settings);

}  // namespace deepslam::tools
