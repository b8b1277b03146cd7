// What a capture's folder holds beside the capture.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace deepslam::convert {

// Names of files and folders that belong to no layout, sorted.
[[nodiscard]] std::vector<std::string> OtherFiles(const std::filesystem::path& folder);

}  // namespace deepslam::convert
