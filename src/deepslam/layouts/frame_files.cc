#include "deepslam/layouts/frame_files.h"

#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/dataset/file_frames.h"
#include "deepslam/formats/text_lines.h"
#include "deepslam/layouts/image_folders.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

// "frame-000012.color.png" -> 12; nothing for other files.
std::optional<std::int64_t> NumberOf(std::string_view name, std::string_view kind) {
  constexpr std::string_view kPrefix = "frame-";
  if (!name.starts_with(kPrefix)) return std::nullopt;
  name.remove_prefix(kPrefix.size());
  const std::size_t digits = name.find_first_not_of("0123456789");
  if (digits == 0 || digits == std::string_view::npos || digits > 12) return std::nullopt;
  if (!name.substr(digits).starts_with(kind)) return std::nullopt;
  return static_cast<std::int64_t>(*formats::ParseNumber(name.substr(0, digits)));
}

// The first folder seq-XX with frames; empty when there is none.
std::string SequenceIn(const fs::path& folder) {
  std::string first;
  std::error_code code;
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end;
       entry.increment(code)) {
    const std::string name = entry->path().filename().string();
    if (name.starts_with("seq") && (first.empty() || name < first) && HasFrameFiles(entry->path()))
      first = name;
  }
  return first;
}

}  // namespace

bool HasFrameFiles(const fs::path& folder) {
  for (const std::string& name : dataset::ListFiles(folder)) {
    if (NumberOf(name, ".color.") || NumberOf(name, ".depth.")) return true;
  }
  return false;
}

std::vector<dataset::ImagePair> FrameFilePairs(const fs::path& folder) {
  std::map<std::int64_t, std::string> depth_files;
  std::map<std::int64_t, dataset::ImagePair> by_number;
  const std::vector<std::string> names = dataset::ListFiles(folder);
  for (const std::string& name : names) {
    const std::optional<std::int64_t> number = NumberOf(name, ".depth.");
    if (number && IsDepthName(name)) depth_files.emplace(*number, name);
  }
  for (const std::string& name : names) {
    const std::optional<std::int64_t> number = NumberOf(name, ".color.");
    if (!number || !IsColourName(name)) continue;
    const auto found = depth_files.find(*number);
    std::string depth =
        found == depth_files.end() ? name.substr(0, name.find('.')) + ".depth.png" : found->second;
    const double time_s = TimeOfNumber(*number);
    by_number.try_emplace(*number,
                          dataset::ImagePair{{time_s, name, 0}, {time_s, std::move(depth), 0}});
  }
  std::vector<dataset::ImagePair> pairs;
  pairs.reserve(by_number.size());
  for (auto& [number, pair] : by_number) pairs.push_back(std::move(pair));
  return pairs;
}

std::vector<std::string> FramePoseNames(const std::vector<dataset::ImagePair>& pairs) {
  std::vector<std::string> names;
  for (const dataset::ImagePair& pair : pairs)
    names.push_back(pair.colour.file.substr(0, pair.colour.file.find('.')) + ".pose.txt");
  return names;
}

LayoutMatch MatchFrameFiles(const fs::path& folder) {
  if (HasFrameFiles(folder)) return {true, 3, {}};
  const std::string sequence = SequenceIn(folder);
  if (sequence.empty()) return {false, 0, {"frame-*.color.png, frame-*.depth.png"}};
  return {false,
          2,
          {fmt::format("frame-*.color.png (they lie in its sequences: name {})",
                       (folder / sequence).string())}};
}

Status CheckFrameFiles(const fs::path& folder, const std::vector<dataset::ImagePair>& pairs) {
  if (!pairs.empty()) return Ok();
  return InvalidInput(fmt::format(
      "{}: holds no frame-*.color.png; is the sequence unpacked completely?", folder.string()));
}

}  // namespace deepslam::layouts
