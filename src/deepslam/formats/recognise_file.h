// What a file is that was named, or lies where a capture should, and what to do with it: archives
// and recordings are told by their first bytes, whatever their names say.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace deepslam::formats {

// "an Azure Kinect recording: ..."; nothing for files that are none of them. A folder is one where
// it holds what a recording unpacks to.
[[nodiscard]] std::optional<std::string> WhatIsToBeDone(const std::filesystem::path& file);

}  // namespace deepslam::formats
