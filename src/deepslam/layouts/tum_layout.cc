#include "deepslam/layouts/tum_layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "deepslam/dataset/doubts.h"
#include "deepslam/dataset/file_frames.h"
#include "deepslam/dataset/read_bytes.h"
#include "deepslam/formats/text_lines.h"
#include "deepslam/layouts/layout.h"
#include "deepslam/layouts/open_files.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

// Half a frame of a 30 Hz camera, rounded up: further apart, colour and depth show different
// moments.
constexpr double kAssociationToleranceS = 0.02;
// Three frames at 30 Hz: hands do not move evenly over longer gaps.
constexpr double kMaxPoseGapS = 0.1;
constexpr double kEth3dUnitsPerM = 5000;  // as TUM's, by the benchmark's documentation
// As TUM's own script and others' name the list of pairs.
constexpr std::array<std::string_view, 5> kAssociationNames = {
    "associations.txt", "associated.txt", "associate.txt", "association.txt", "assoc.txt"};
constexpr std::string_view kCalibrationName = "calibration.txt";

bool IsFile(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

// Of images that hardly pair: times in another unit are further apart than they say.
Status CheckUnitOfTimes(const std::vector<dataset::TimedFile>& files, const fs::path& list) {
  std::vector<double> times_s;
  for (const dataset::TimedFile& file : files) times_s.push_back(file.time_s);
  const std::string_view unit = dataset::UnitOfTimes(times_s);
  if (unit.empty()) return Ok();
  return InvalidInput(
      fmt::format("{}: times lie {:.4g} apart: {}? They have to be in seconds; convert both lists",
                  list.string(),
                  times_s[1] - times_s[0],
                  unit));
}

Result<std::vector<dataset::ImagePair>> PairsByTime(const fs::path& folder,
                                                    std::vector<std::string>& warnings) {
  std::vector<std::vector<dataset::TimedFile>> lists;
  for (const char* name : {"rgb.txt", "depth.txt"}) {
    const fs::path list = folder / name;
    const Result<std::string> text = dataset::ReadTextFile(list);
    if (!text) {
      return InvalidInput(
          text.error().message +
          "; a capture needs associations.txt, or rgb.txt and depth.txt (lines 'time file')");
    }
    Result<std::vector<dataset::TimedFile>> files = formats::ParseFileList(*text, list, warnings);
    if (!files) return files.error();
    lists.push_back(*std::move(files));
  }
  if (formats::NumClockSegments(lists[0]) != formats::NumClockSegments(lists[1])) {
    return InvalidInput(
        fmt::format("{}: the times of rgb.txt fall back {} times, those of depth.txt {} times, so "
                    "that which images belong together cannot be told; write associations.txt "
                    "(lines 'time rgb-file time depth-file')",
                    folder.string(),
                    formats::NumClockSegments(lists[0]) - 1,
                    formats::NumClockSegments(lists[1]) - 1));
  }
  std::vector<dataset::ImagePair> pairs =
      formats::AssociateByTime(lists[0], lists[1], kAssociationToleranceS);
  if (2 * pairs.size() < std::min(lists[0].size(), lists[1].size())) {
    for (const auto& [list, name] : {std::pair(&lists[1], "depth.txt"), {&lists[0], "rgb.txt"}}) {
      if (Status sane = CheckUnitOfTimes(*list, folder / name); !sane) return sane.error();
    }
  }
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

std::optional<Pose3> PoseWithin(const std::vector<formats::TimedPose>& poses,
                                int segment,
                                double time_s) {
  return formats::PoseAt(
      formats::ClockSegment(poses, segment), time_s, kAssociationToleranceS, kMaxPoseGapS);
}

// Nothing where several segments have one.
std::optional<Pose3> OnlyPose(const std::vector<formats::TimedPose>& poses, double time_s) {
  std::optional<Pose3> only;
  for (int segment = 0; segment < formats::NumClockSegments(poses); ++segment) {
    const std::optional<Pose3> pose = PoseWithin(poses, segment, time_s);
    if (pose && only) return std::nullopt;
    if (pose) only = pose;
  }
  return only;
}

int NumClockSegmentsOver(const std::vector<dataset::ImagePair>& pairs, double time_s) {
  int count = 0;
  for (int number = 0; number < formats::NumClockSegments(pairs); ++number) {
    const std::span<const dataset::ImagePair> segment = formats::ClockSegment(pairs, number);
    count += !segment.empty() && segment.front().depth.time_s <= time_s &&
                     time_s <= segment.back().depth.time_s
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
  const Result<std::string> text = dataset::ReadTextFile(file);
  if (!text) return text.error();
  const auto numbers = formats::ParseNumbers(*text, file, 4, "fx fy cx cy");
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

// What is said where the times of poses and images are of two clocks, or two units; empty where
// some poses lie near.
std::string FaultOfTimes(const std::vector<formats::TimedPose>& poses,
                         const std::vector<std::optional<Pose3>>& at,
                         const std::vector<dataset::ImagePair>& pairs) {
  if (poses.empty() || pairs.empty()) return {};
  const auto num_near =
      std::ranges::count_if(at, [](const auto& pose) { return pose.has_value(); });
  std::vector<double> pose_times_s, image_times_s;
  for (const formats::TimedPose& pose : poses) pose_times_s.push_back(pose.time_s);
  for (const dataset::ImagePair& pair : pairs) image_times_s.push_back(pair.depth.time_s);
  const std::string_view unit = dataset::UnitOfTimes(pose_times_s);
  // One may lie near by chance: both may begin with 0.
  if (num_near <= 1 && pairs.size() > 1 && !unit.empty() &&
      dataset::UnitOfTimes(image_times_s).empty()) {
    return fmt::format("the times of poses look like {}, those of images like seconds", unit);
  }
  if (num_near > 0) return {};
  return fmt::format(
      "no pose lies within {} s of an image (poses {:.3f} to {:.3f} s, images {:.3f} "
      "to {:.3f} s)",
      kAssociationToleranceS,
      pose_times_s.front(),
      pose_times_s.back(),
      image_times_s.front(),
      image_times_s.back());
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
  const Result<std::vector<formats::TimedPose>> poses = formats::ParsePoses(**text, file, warnings);
  if (!poses) return poses.error();
  if (formats::NumClockSegments(*poses) != formats::NumClockSegments(pairs) && !poses->empty()) {
    warnings.push_back(
        fmt::format("{}: its times do not fall back where those of the images do; frames whose "
                    "time stands for several moments have no pose",
                    file.string()));
  }
  std::vector<std::optional<Pose3>> at = PosesAt(*poses, pairs);
  if (const std::string fault = FaultOfTimes(*poses, at, pairs); !fault.empty()) {
    warnings.push_back(fmt::format(
        "{}: {}; none was taken: write both in seconds of one clock", file.string(), fault));
    at.assign(pairs.size(), std::nullopt);
  }
  return at;
}

Result<OpenedLayout> OpenLists(const LayoutSource& source,
                               FilesOfLayout files,
                               const dataset::CaptureCameras& cameras,
                               std::vector<std::string> warnings) {
  const fs::path file = source.path / kPosesName;
  Result<SettledImages> settled = SettleImages(source, cameras, files.pairs, warnings);
  if (!settled) return settled.error();
  files.settled = *std::move(settled);
  Result<formats::FramePoses> poses = ReadPoses(file, files.pairs, files.texts, warnings);
  if (!poses) return poses.error();
  files.poses = *std::move(poses);
  files.poses_file = file.string();
  files.has_times = true;
  return OpenFiles(source, std::move(files), std::move(warnings));
}

}  // namespace

std::vector<std::string> ListsOf(const fs::path& folder) {
  std::vector<std::string> found;
  for (const std::string_view name : kAssociationNames) {
    if (IsFile(folder / name)) found.emplace_back(name);
  }
  for (const char* name : {"rgb.txt", "depth.txt"}) {
    if (IsFile(folder / name)) found.emplace_back(name);
  }
  return found;
}

Result<std::vector<dataset::ImagePair>> ReadPairs(const fs::path& folder,
                                                  std::vector<std::string>& warnings) {
  for (const std::string_view name : kAssociationNames) {
    const fs::path list = folder / name;
    if (!IsFile(list)) continue;
    const Result<std::string> text = dataset::ReadTextFile(list);
    if (!text) return text.error();
    return formats::ParseAssociations(*text, list, warnings);
  }
  return PairsByTime(folder, warnings);
}

std::vector<std::optional<Pose3>> PosesAt(const std::vector<formats::TimedPose>& poses,
                                          const std::vector<dataset::ImagePair>& pairs) {
  const bool alike = formats::NumClockSegments(poses) == formats::NumClockSegments(pairs);
  std::vector<std::optional<Pose3>> at;
  at.reserve(pairs.size());
  for (const dataset::ImagePair& pair : pairs) {
    if (alike) {
      at.push_back(PoseWithin(poses, ClockSegmentOf(pair), pair.depth.time_s));
    } else {
      at.push_back(NumClockSegmentsOver(pairs, pair.depth.time_s) == 1
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
  FilesOfLayout files{"tum", {}, *std::move(pairs), {}, {}, {}, {}, true};
  if (source.settings_text) {
    const Status complete = RequireComplete(source.settings, source.path / kSettingsName);
    if (!complete) return complete.error();
    return OpenLists(source, std::move(files), {}, std::move(warnings));
  }
  const Result<dataset::CaptureSettings> named = dataset::SettingsFromName(WithName(source.path));
  if (!named) return named.error();
  warnings.insert(warnings.end(), named->warnings.begin(), named->warnings.end());
  files.optics.colour = files.optics.depth = named->lens;
  return OpenLists(
      source, std::move(files), WithStated(*named, dataset::CaptureCameras()), std::move(warnings));
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
  FilesOfLayout files{
      "eth3d", {{kCalibrationName, *calibration}}, *std::move(pairs), {}, {}, {}, {}, true};
  return OpenLists(
      source, std::move(files), {*camera, *camera, Pose3(), kEth3dUnitsPerM}, std::move(warnings));
}

}  // namespace deepslam::layouts
