// Colour of a capture that lies in a video.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/dataset/video_file.h"

namespace deepslam::layouts {

// The first of these that lies there, its end in small or capital letters.
[[nodiscard]] std::optional<std::filesystem::path> FindVideo(
    const std::filesystem::path& folder, std::span<const std::string_view> names);

struct VideoColour {
  std::shared_ptr<dataset::VideoFile> video;
  std::string digest;  // SHA-256 of the file
};
[[nodiscard]] Result<VideoColour> OpenVideoColour(const std::filesystem::path& file);

}  // namespace deepslam::layouts
