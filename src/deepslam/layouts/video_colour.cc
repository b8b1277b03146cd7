#include "deepslam/layouts/video_colour.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include "deepslam/dataset/file_frames.h"

namespace deepslam::layouts {
namespace {

std::string Small(std::string text) {
  std::ranges::transform(
      text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

}  // namespace

std::optional<std::filesystem::path> FindVideo(const std::filesystem::path& folder,
                                               std::span<const std::string_view> names) {
  const std::vector<std::string> files = dataset::ListFiles(folder);
  for (const std::string_view name : names) {
    const auto found =
        std::ranges::find_if(files, [&](const std::string& file) { return Small(file) == name; });
    if (found != files.end()) return folder / *found;
  }
  return std::nullopt;
}

Result<VideoColour> OpenVideoColour(const std::filesystem::path& file) {
  Result<std::unique_ptr<dataset::VideoFile>> video = dataset::VideoFile::Open(file);
  if (!video) return video.error();
  Result<std::string> digest = dataset::HashLargeFile(file);
  if (!digest) return digest.error();
  return VideoColour{*std::move(video), *std::move(digest)};
}

}  // namespace deepslam::layouts
