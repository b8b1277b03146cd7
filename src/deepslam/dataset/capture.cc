#include "deepslam/dataset/capture.h"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/parallel.h"
#include "deepslam/core/sha256.h"
#include "deepslam/dataset/capture_settings.h"
#include "deepslam/dataset/image_files.h"
#include "deepslam/dataset/tum_lists.h"
#include "deepslam/dataset/tum_reader.h"

namespace deepslam::dataset {
namespace {

namespace fs = std::filesystem;

// Half a frame of a 30 Hz camera, rounded up: further apart, colour and depth show different
// moments.
constexpr double kAssociationToleranceS = 0.02;
constexpr double kMaxPoseGapS = 0.1;
constexpr int kNumProbedFrames = 8;
constexpr std::string_view kSettingsName = "capture.yaml";
constexpr std::string_view kPosesName = "groundtruth.txt";

bool IsFile(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

// Text of an optional file: nothing when it does not exist.
Result<std::optional<std::string>> ReadOptional(const fs::path& file) {
  std::error_code ignored;
  if (!fs::exists(fs::symlink_status(file, ignored))) return std::optional<std::string>();
  Result<std::string> text = ReadFileBytes(file);
  if (!text) return text.error();
  return std::optional<std::string>(*std::move(text));
}

Result<std::vector<ImagePair>> PairsByTime(const fs::path& folder,
                                           std::vector<std::string>& warnings) {
  std::vector<std::vector<TimedFile>> lists;
  for (const char* name : {"rgb.txt", "depth.txt"}) {
    const fs::path list = folder / name;
    const Result<std::string> text = ReadFileBytes(list);
    if (!text) {
      return InvalidInput(
          text.error().message +
          "; a capture needs associations.txt, or rgb.txt and depth.txt (lines 'time file')");
    }
    Result<std::vector<TimedFile>> files = ParseFileList(*text, list, warnings);
    if (!files) return files.error();
    lists.push_back(*std::move(files));
  }
  std::vector<ImagePair> pairs = AssociateByTime(lists[0], lists[1], kAssociationToleranceS);
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

Result<std::vector<ImagePair>> ReadPairs(const fs::path& folder,
                                         std::vector<std::string>& warnings) {
  for (const char* name : {"associations.txt", "associated.txt"}) {
    const fs::path list = folder / name;
    if (!IsFile(list)) continue;
    const Result<std::string> text = ReadFileBytes(list);
    if (!text) return text.error();
    return ParseAssociations(*text, list, warnings);
  }
  return PairsByTime(folder, warnings);
}

Status CheckFilesExist(const fs::path& folder,
                       const std::vector<ImagePair>& pairs,
                       std::vector<std::string>& warnings) {
  std::size_t num_missing = 0;
  const TimedFile* first = nullptr;
  for (const ImagePair& pair : pairs) {
    const bool colour_there = IsFile(folder / pair.colour.file);
    if (colour_there && IsFile(folder / pair.depth.file)) continue;
    ++num_missing;
    if (first == nullptr) first = colour_there ? &pair.depth : &pair.colour;
  }
  if (num_missing == 0) return Ok();
  const std::string what =
      fmt::format("{}: file is missing (line {} of its list); {} of {} frames lack an image",
                  (folder / first->file).string(),
                  first->line,
                  num_missing,
                  pairs.size());
  if (2 * num_missing > pairs.size())
    return InvalidInput(what + ": is the capture unpacked completely?");
  warnings.push_back(what + " and will be skipped");
  return Ok();
}

// File contents enter by their own digests, so that files can be hashed in parallel.
std::string HashContents(const fs::path& folder,
                         const std::vector<ImagePair>& pairs,
                         const std::optional<std::string>& settings_text,
                         const std::optional<std::string>& poses_text) {
  std::vector<std::string> digests(2 * pairs.size());
  ParallelFor(digests.size(), [&](std::size_t i) {
    const ImagePair& pair = pairs[i / 2];
    const Result<std::string> bytes =
        ReadFileBytes(folder / (i % 2 == 0 ? pair.colour : pair.depth).file);
    digests[i] = bytes ? Sha256Hex(*bytes) : "unreadable";
  });
  Sha256 hash;
  const auto add_text = [&](std::string_view name, const std::optional<std::string>& text) {
    hash.Update(fmt::format("{} {}\n", name, text ? Sha256Hex(*text) : "none"));
  };
  hash.Update("tum 1\n");
  add_text(kSettingsName, settings_text);
  add_text(kPosesName, poses_text);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const ImagePair& pair = pairs[i];
    hash.Update(fmt::format("{} {} {}\n{} {} {}\n",
                            pair.colour.time_s,
                            pair.colour.file,
                            digests[2 * i],
                            pair.depth.time_s,
                            pair.depth.file,
                            digests[2 * i + 1]));
  }
  return hash.HexDigest();
}

// Refuses captures of which no looked-at frame can be used: wrong camera, wrong units, wrong files.
Status Probe(const FrameSource& frames, const fs::path& folder) {
  const int num_probes = std::min(kNumProbedFrames, frames.num_frames());
  std::optional<Error> first_error;
  int num_readable = 0;
  for (int i = 0; i < num_probes; ++i) {
    const int idx =
        static_cast<int>(static_cast<std::int64_t>(i) * frames.num_frames() / num_probes);
    const Result<Frame> frame = frames.Read(FrameIdx{idx});
    if (!frame) {
      if (!first_error) first_error = frame.error();
      continue;
    }
    ++num_readable;
    if (std::any_of(frame->depth_m.begin(), frame->depth_m.end(), [](float d) { return d > 0; }))
      return Ok();
  }
  if (num_readable > 0) {
    return InvalidInput(
        fmt::format("{}: no valid depth (above 0, up to {} m) in any of {} frames looked at; check "
                    "the depth images and 'depth_units_per_m' in capture.yaml",
                    folder.string(),
                    kMaxDepthM,
                    num_readable));
  }
  return InvalidInput(fmt::format("{}: none of {} frames looked at can be used; the first: {}",
                                  folder.string(),
                                  num_probes,
                                  first_error->message));
}

Result<CaptureSettings> ReadSettings(const fs::path& folder,
                                     const std::optional<std::string>& text) {
  return text ? ParseCaptureSettings(*text, folder / kSettingsName) : SettingsFromName(folder);
}

// "capture/" and "." have no file name of their own.
fs::path WithName(const fs::path& folder) {
  std::error_code code;
  const fs::path full = fs::weakly_canonical(folder, code);
  return code ? folder : full;
}

}  // namespace

Result<Capture> OpenCapture(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::exists(folder, ignored))
    return InvalidInput(
        fmt::format("{}: folder is missing; name a capture's folder", folder.string()));
  if (!fs::is_directory(folder, ignored)) {
    return InvalidInput(fmt::format(
        "{}: not a folder; name the folder that holds rgb.txt and depth.txt", folder.string()));
  }
  const Result<std::optional<std::string>> settings_text = ReadOptional(folder / kSettingsName);
  if (!settings_text) return settings_text.error();
  const Result<std::optional<std::string>> poses_text = ReadOptional(folder / kPosesName);
  if (!poses_text) return poses_text.error();

  Capture capture;
  capture.name = WithName(folder).filename().string();
  Result<std::vector<ImagePair>> pairs = ReadPairs(folder, capture.warnings);
  if (!pairs) return pairs.error();
  const Result<CaptureSettings> settings =
      ReadSettings(*settings_text ? folder : WithName(folder), *settings_text);
  if (!settings) return settings.error();
  capture.warnings.insert(
      capture.warnings.end(), settings->warnings.begin(), settings->warnings.end());
  const Status files_exist = CheckFilesExist(folder, *pairs, capture.warnings);
  if (!files_exist) return files_exist.error();

  for (const ImagePair& pair : *pairs) capture.colour_files.push_back(pair.colour.file);
  std::vector<std::optional<Pose3>> world_from_camera(pairs->size());
  if (*poses_text) {
    const Result<std::vector<TimedPose>> poses =
        ParsePoses(**poses_text, folder / kPosesName, capture.warnings);
    if (!poses) return poses.error();
    for (std::size_t i = 0; i < pairs->size(); ++i) {
      world_from_camera[i] =
          PoseAt(*poses, (*pairs)[i].depth.time_s, kAssociationToleranceS, kMaxPoseGapS);
      capture.has_poses = capture.has_poses || world_from_camera[i].has_value();
    }
  }
  capture.content_hash = HashContents(folder, *pairs, *settings_text, *poses_text);
  capture.frames =
      MakeTumFrameSource(folder, *settings, *std::move(pairs), std::move(world_from_camera));
  const Status usable = Probe(*capture.frames, folder);
  if (!usable) return usable.error();
  return capture;
}

}  // namespace deepslam::dataset
