#include "deepslam/layouts/tum_layout.h"

#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "deepslam/dataset/file_frames.h"
#include "deepslam/dataset/read_bytes.h"
#include "deepslam/layouts/layout.h"
#include "deepslam/layouts/text_lines.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

// Half a frame of a 30 Hz camera, rounded up: further apart, colour and depth show different
// moments.
constexpr double kAssociationToleranceS = 0.02;
constexpr double kMaxPoseGapS = 0.1;
constexpr double kEth3dUnitsPerM = 5000;
constexpr std::string_view kCalibrationName = "calibration.txt";

bool IsFile(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

Result<std::vector<dataset::ImagePair>> PairsByTime(const fs::path& folder,
                                                    std::vector<std::string>& warnings) {
  std::vector<std::vector<dataset::TimedFile>> lists;
  for (const char* name : {"rgb.txt", "depth.txt"}) {
    const fs::path list = folder / name;
    const Result<std::string> text = dataset::ReadFileBytes(list);
    if (!text) {
      return InvalidInput(
          text.error().message +
          "; a capture needs associations.txt, or rgb.txt and depth.txt (lines 'time file')");
    }
    Result<std::vector<dataset::TimedFile>> files = ParseFileList(*text, list, warnings);
    if (!files) return files.error();
    lists.push_back(*std::move(files));
  }
  if (NumStretches(lists[0]) != NumStretches(lists[1])) {
    return InvalidInput(
        fmt::format("{}: the times of rgb.txt fall back {} times, those of depth.txt {} times, so "
                    "that which images belong together cannot be told; write associations.txt "
                    "(lines 'time rgb-file time depth-file')",
                    folder.string(),
                    NumStretches(lists[0]) - 1,
                    NumStretches(lists[1]) - 1));
  }
  std::vector<dataset::ImagePair> pairs =
      AssociateByTime(lists[0], lists[1], kAssociationToleranceS);
  if (pairs.empty()) {
    return InvalidInput(
        fmt::format("{}: no colour image of rgb.txt lies within {} s of a depth image of "
                    "depth.txt; both must use one clock",
                    folder.string(),
                    kAssociationToleranceS));
  }
  if (const std::size_t left_out = lists[1].size() - pairs.size(); left_out > 0) {
    warnings.push_back(
        fmt::format("{}: {} of {} depth images have no colour image within {} s and were left out",
                    (folder / "depth.txt").string(),
                    left_out,
                    lists[1].size(),
                    kAssociationToleranceS));
  }
  return pairs;
}

std::optional<Pose3> PoseWithin(const std::vector<TimedPose>& poses, int stretch, double time_s) {
  return PoseAt(Stretch(poses, stretch), time_s, kAssociationToleranceS, kMaxPoseGapS);
}

// Nothing where several stretches have one.
std::optional<Pose3> OnlyPose(const std::vector<TimedPose>& poses, double time_s) {
  std::optional<Pose3> only;
  for (int stretch = 0; stretch < NumStretches(poses); ++stretch) {
    const std::optional<Pose3> pose = PoseWithin(poses, stretch, time_s);
    if (pose && only) return std::nullopt;
    if (pose) only = pose;
  }
  return only;
}

int NumStretchesOver(const std::vector<dataset::ImagePair>& pairs, double time_s) {
  int count = 0;
  for (int number = 0; number < NumStretches(pairs); ++number) {
    const std::span<const dataset::ImagePair> stretch = Stretch(pairs, number);
    count += !stretch.empty() && stretch.front().depth.time_s <= time_s &&
                     time_s <= stretch.back().depth.time_s
                 ? 1
                 : 0;
  }
  return count;
}

// "capture/" and "." have no file name of their own.
fs::path WithName(const fs::path& folder) {
  std::error_code code;
  const fs::path full = fs::weakly_canonical(folder, code);
  return code ? folder : full;
}

// calibration.txt of ETH3D-SLAM: fx fy cx cy, pixel (0, 0) being the centre of the first pixel; the
// images' size is their own.
Result<PinholeCamera> ReadCalibration(const fs::path& folder,
                                      const std::vector<dataset::ImagePair>& pairs) {
  const fs::path file = folder / kCalibrationName;
  const Result<std::string> text = dataset::ReadFileBytes(file);
  if (!text) return text.error();
  const auto numbers = ParseNumbers(*text, file, 4, "fx fy cx cy");
  if (!numbers) return numbers.error();
  Result<dataset::ImageSize> size = InvalidInput("");
  for (const dataset::ImagePair& pair : pairs) {
    size = dataset::ReadImageSize(folder / pair.colour.file);
    if (size) break;
  }
  if (!size) return size.error();
  const PinholeCamera camera{
      size->width, size->height, (*numbers)[0], (*numbers)[1], (*numbers)[2], (*numbers)[3]};
  const Status plausible = dataset::CheckCamera(camera, file);
  if (!plausible) return plausible.error();
  return camera;
}

// Of each pair; its text joins `texts`. No poses where the file does not exist.
Result<std::vector<std::optional<Pose3>>> ReadPoses(const fs::path& file,
                                                    const std::vector<dataset::ImagePair>& pairs,
                                                    std::vector<dataset::NamedText>& texts,
                                                    std::vector<std::string>& warnings) {
  const Result<std::optional<std::string>> text = dataset::ReadOptional(file);
  if (!text) return text.error();
  texts.emplace_back(kPosesName, *text);
  if (!*text) return std::vector<std::optional<Pose3>>(pairs.size());
  const Result<std::vector<TimedPose>> poses = ParsePoses(**text, file, warnings);
  if (!poses) return poses.error();
  if (NumStretches(*poses) != NumStretches(pairs) && !poses->empty()) {
    warnings.push_back(
        fmt::format("{}: its times do not fall back where those of the images do; frames whose "
                    "time stands for several moments have no pose",
                    file.string()));
  }
  return PosesAt(*poses, pairs);
}

Result<OpenedLayout> OpenLists(const LayoutSource& source,
                               std::string_view tag,
                               std::vector<dataset::NamedText> texts,
                               std::vector<dataset::ImagePair> pairs,
                               const dataset::CaptureCameras& cameras,
                               std::vector<std::string> warnings) {
  const fs::path& folder = source.path;
  const Status files_exist = dataset::CheckFilesExist(folder, pairs, warnings);
  if (!files_exist) return files_exist.error();
  const Result<std::vector<std::optional<Pose3>>> world_from_colour =
      ReadPoses(folder / kPosesName, pairs, texts, warnings);
  if (!world_from_colour) return world_from_colour.error();
  Result<std::string> hash = dataset::HashFiles(tag, texts, folder, pairs);
  if (!hash) return hash.error();
  return OpenedLayout{
      dataset::MakeFileFrames(folder, cameras, std::move(pairs), *world_from_colour),
      *std::move(hash),
      std::move(warnings)};
}

}  // namespace

std::vector<std::string> ListsOf(const fs::path& folder) {
  std::vector<std::string> found;
  for (const char* name : {"associations.txt", "associated.txt", "rgb.txt", "depth.txt"}) {
    if (IsFile(folder / name)) found.emplace_back(name);
  }
  return found;
}

Result<std::vector<dataset::ImagePair>> ReadPairs(const fs::path& folder,
                                                  std::vector<std::string>& warnings) {
  for (const char* name : {"associations.txt", "associated.txt"}) {
    const fs::path list = folder / name;
    if (!IsFile(list)) continue;
    const Result<std::string> text = dataset::ReadFileBytes(list);
    if (!text) return text.error();
    return ParseAssociations(*text, list, warnings);
  }
  return PairsByTime(folder, warnings);
}

std::vector<std::optional<Pose3>> PosesAt(const std::vector<TimedPose>& poses,
                                          const std::vector<dataset::ImagePair>& pairs) {
  const bool alike = NumStretches(poses) == NumStretches(pairs);
  std::vector<std::optional<Pose3>> at;
  at.reserve(pairs.size());
  for (const dataset::ImagePair& pair : pairs) {
    if (alike) {
      at.push_back(PoseWithin(poses, StretchOf(pair), pair.depth.time_s));
    } else {
      at.push_back(NumStretchesOver(pairs, pair.depth.time_s) == 1
                       ? OnlyPose(poses, pair.depth.time_s)
                       : std::nullopt);
    }
  }
  return at;
}

LayoutMatch MatchTum(const fs::path& path) {
  const std::vector<std::string> lists = ListsOf(path);
  LayoutMatch match{!lists.empty(), static_cast<int>(lists.size()), {}};
  if (lists.empty()) match.missing.emplace_back("rgb.txt and depth.txt, or associations.txt");
  std::error_code ignored;
  for (const char* folder : {"rgb", "depth"}) {
    if (fs::is_directory(path / folder, ignored)) {
      ++match.num_found;
    } else {
      match.missing.push_back(std::string(folder) + "/");
    }
  }
  return match;
}

Result<OpenedLayout> OpenTum(const LayoutSource& source) {
  std::vector<std::string> warnings;
  Result<std::vector<dataset::ImagePair>> pairs = ReadPairs(source.path, warnings);
  if (!pairs) return pairs.error();
  dataset::CaptureSettings settings = source.settings;
  if (source.settings_text) {
    const Status complete = dataset::RequireComplete(settings, source.path / kSettingsName);
    if (!complete) return complete.error();
  } else {
    Result<dataset::CaptureSettings> named = dataset::SettingsFromName(WithName(source.path));
    if (!named) return named.error();
    warnings.insert(warnings.end(), named->warnings.begin(), named->warnings.end());
    settings = *std::move(named);
  }
  return OpenLists(source,
                   "tum",
                   {{kSettingsName, source.settings_text}},
                   *std::move(pairs),
                   WithStated(settings, {}),
                   std::move(warnings));
}

LayoutMatch MatchEth3d(const fs::path& path) {
  LayoutMatch match = MatchTum(path);
  if (IsFile(path / kCalibrationName)) {
    ++match.num_found;
    // A capture.yaml with a camera says more; it is read as TUM's.
    match.matches = match.matches && !IsFile(path / kSettingsName);
  } else {
    match.matches = false;
    match.missing.emplace_back(kCalibrationName);
  }
  return match;
}

Result<OpenedLayout> OpenEth3d(const LayoutSource& source) {
  std::vector<std::string> warnings;
  Result<std::vector<dataset::ImagePair>> pairs = ReadPairs(source.path, warnings);
  if (!pairs) return pairs.error();
  const Result<PinholeCamera> camera = ReadCalibration(source.path, *pairs);
  if (!camera) return camera.error();
  const Result<std::optional<std::string>> calibration =
      dataset::ReadOptional(source.path / kCalibrationName);
  if (!calibration) return calibration.error();
  return OpenLists(source,
                   "eth3d",
                   {{kSettingsName, source.settings_text}, {kCalibrationName, *calibration}},
                   *std::move(pairs),
                   WithStated(source.settings, {*camera, *camera, Pose3(), kEth3dUnitsPerM}),
                   std::move(warnings));
}

}  // namespace deepslam::layouts
