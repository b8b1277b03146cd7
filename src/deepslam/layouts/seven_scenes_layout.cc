// 7-Scenes (Microsoft): one folder per sequence, three files per frame. Depth in millimetres,
// 65535 where nothing was measured; poses are world from depth camera. Colour and depth are as a
// Kinect gave them: not registered, not calibrated.
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/dataset/file_frames.h"
#include "deepslam/layouts/layout.h"
#include "deepslam/layouts/pose_matrix.h"
#include "deepslam/layouts/text_lines.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

constexpr double kUnitsPerM = 1000;
// What the data set's page says of the depth camera.
constexpr PinholeCamera kKinectDepth{640, 480, 585, 585, 320, 240};
// It says nothing of the colour camera: a Kinect's usual values. It sits 25 mm to the right.
constexpr PinholeCamera kKinectColour{640, 480, 525, 525, 320, 240};
constexpr double kKinectBaselineM = 0.025;

// "frame-000012.color.png" -> 12; nothing for other files.
std::optional<std::int64_t> NumberOf(std::string_view name, std::string_view kind) {
  constexpr std::string_view kPrefix = "frame-";
  if (!name.starts_with(kPrefix)) return std::nullopt;
  name.remove_prefix(kPrefix.size());
  const std::size_t digits = name.find_first_not_of("0123456789");
  if (digits == 0 || digits == std::string_view::npos || digits > 12) return std::nullopt;
  if (!name.substr(digits).starts_with(kind)) return std::nullopt;
  return static_cast<std::int64_t>(*ParseNumber(name.substr(0, digits)));
}

bool HasFrames(const fs::path& folder) {
  for (const std::string& name : dataset::ListFiles(folder)) {
    if (NumberOf(name, ".color.") || NumberOf(name, ".depth.")) return true;
  }
  return false;
}

// The first folder seq-XX with frames; empty when there is none.
std::string SequenceIn(const fs::path& folder) {
  std::string first;
  std::error_code code;
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end;
       entry.increment(code)) {
    const std::string name = entry->path().filename().string();
    if (name.starts_with("seq") && (first.empty() || name < first) && HasFrames(entry->path()))
      first = name;
  }
  return first;
}

std::vector<dataset::ImagePair> PairsIn(const fs::path& folder) {
  std::map<std::int64_t, dataset::ImagePair> by_number;
  for (const std::string& name : dataset::ListFiles(folder)) {
    const std::optional<std::int64_t> number = NumberOf(name, ".color.");
    if (!number) continue;
    const std::string stem = name.substr(0, name.find('.'));
    const double time_s = TimeOfNumber(*number);
    by_number.try_emplace(*number,
                          dataset::ImagePair{{time_s, name, 0}, {time_s, stem + ".depth.png", 0}});
  }
  std::vector<dataset::ImagePair> pairs;
  pairs.reserve(by_number.size());
  for (auto& [number, pair] : by_number) pairs.push_back(std::move(pair));
  return pairs;
}

Status CheckKinect(const fs::path& folder, const std::vector<dataset::ImagePair>& pairs) {
  for (const dataset::ImagePair& pair : pairs) {
    const Result<dataset::ImageSize> size = dataset::ReadImageSize(folder / pair.colour.file);
    if (!size) continue;
    if (size->width == kKinectColour.width && size->height == kKinectColour.height) return Ok();
    return InvalidInput(
        fmt::format("{}: is {} x {} px, not a Kinect's 640 x 480; state 'camera' in {}",
                    (folder / pair.colour.file).string(),
                    size->width,
                    size->height,
                    kSettingsName));
  }
  return Ok();  // nothing is readable: told later
}

struct Poses {
  std::vector<std::optional<Pose3>> world_from_depth;
  std::string text;  // all files, with their names, for the hash
};

Result<Poses> ReadPoses(const fs::path& folder,
                        const std::vector<dataset::ImagePair>& pairs,
                        std::vector<std::string>& warnings) {
  Poses poses;
  std::size_t num_unusable = 0;
  std::string first_unusable;
  for (const dataset::ImagePair& pair : pairs) {
    const std::string name = pair.colour.file.substr(0, pair.colour.file.find('.')) + ".pose.txt";
    const Result<std::optional<std::string>> text = dataset::ReadOptional(folder / name);
    if (!text) return text.error();
    poses.world_from_depth.emplace_back();
    if (!*text) continue;
    poses.text += fmt::format("{}\n{}\n", name, **text);
    const auto numbers = ParseNumbers(**text, folder / name, 16, "a 4 x 4 matrix");
    if (!numbers) return numbers.error();
    poses.world_from_depth.back() = PoseOfMatrix(std::span<const double, 16>(*numbers));
    if (poses.world_from_depth.back()) continue;
    if (num_unusable++ == 0) first_unusable = (folder / name).string();
  }
  if (num_unusable > 0) {
    warnings.push_back(
        fmt::format("{}: {} poses are not finite or no rotations and were left out, this one first",
                    first_unusable,
                    num_unusable));
  }
  return poses;
}

}  // namespace

LayoutMatch MatchSevenScenes(const fs::path& path) {
  LayoutMatch match;
  if (HasFrames(path)) {
    match.matches = true;
    match.num_found = 3;
    return match;
  }
  const std::string sequence = SequenceIn(path);
  if (!sequence.empty()) {
    match.num_found = 2;
    match.missing.push_back(fmt::format("frame-*.color.png (they lie in its sequences: name {})",
                                        (path / sequence).string()));
  } else {
    match.missing.emplace_back("frame-*.color.png, frame-*.depth.png");
  }
  return match;
}

Result<OpenedLayout> OpenSevenScenes(const LayoutSource& source) {
  const fs::path& folder = source.path;
  OpenedLayout opened;
  std::vector<dataset::ImagePair> pairs = PairsIn(folder);
  if (pairs.empty()) {
    return InvalidInput(fmt::format(
        "{}: holds no frame-*.color.png; is the sequence unpacked completely?", folder.string()));
  }
  const Status files_exist = dataset::CheckFilesExist(folder, pairs, opened.warnings);
  if (!files_exist) return files_exist.error();
  dataset::CaptureCameras cameras{kKinectColour,
                                  kKinectDepth,
                                  {Eigen::Quaterniond::Identity(), {-kKinectBaselineM, 0, 0}},
                                  kUnitsPerM};
  if (!source.settings.has_camera()) {
    const Status kinect = CheckKinect(folder, pairs);
    if (!kinect) return kinect.error();
    opened.warnings.push_back(fmt::format(
        "{}: 7-Scenes holds no calibration; depth (585 px) is registered to colour (525 px, 25 mm "
        "beside it) by a Kinect's usual values; state 'camera' in {} if depth is registered "
        "already",
        folder.string(),
        kSettingsName));
  }
  cameras = WithStated(source.settings, cameras);
  const Result<Poses> poses = ReadPoses(folder, pairs, opened.warnings);
  if (!poses) return poses.error();
  std::vector<std::optional<Pose3>> world_from_colour = poses->world_from_depth;
  const Pose3 depth_from_colour = cameras.colour_from_depth.Inverse();
  if (!(cameras.colour_from_depth == Pose3())) {
    for (std::optional<Pose3>& pose : world_from_colour) {
      if (pose) pose = *pose * depth_from_colour;
    }
  }
  Result<std::string> hash =
      dataset::HashFiles("7-scenes",
                         std::vector<dataset::NamedText>{{kSettingsName, source.settings_text},
                                                         {"poses", poses->text}},
                         folder,
                         pairs);
  if (!hash) return hash.error();
  opened.content_hash = *std::move(hash);
  opened.frames = dataset::MakeFileFrames(folder, cameras, std::move(pairs), world_from_colour);
  opened.warnings.push_back(NoTimesWarning(folder));
  opened.has_times = false;
  return opened;
}

}  // namespace deepslam::layouts
