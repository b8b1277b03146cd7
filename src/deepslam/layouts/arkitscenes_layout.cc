// ARKitScenes' raw recordings: lowres_wide/ (256 x 192) or vga_wide/ (640 x 480) with the
// intrinsics of each image in NAME_intrinsics/*.pincam ("width height fx fy cx cy"), lowres_depth/
// (256 x 192, mm, seen from colour's place), confidence/ (0 low, 1 medium, 2 high), all named
// VIDEO_SECONDS.png, and lowres_wide.traj: "seconds rx ry rz tx ty tz", camera from world as a
// rotation vector and a translation.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/dataset/read_bytes.h"
#include "deepslam/formats/text_lines.h"
#include "deepslam/formats/tum_lists.h"
#include "deepslam/geometry/max_position.h"
#include "deepslam/layouts/image_folders.h"
#include "deepslam/layouts/open_files.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

constexpr double kUnitsPerM = 1000;  // millimetres, by the data set's documentation
constexpr int kMinConfidence = 1;    // of 0, 1 and 2 (ARKit's ARConfidenceLevel): medium
// Half a frame at 30 Hz; frames of the streams have equal times but for their last digit.
constexpr double kMaxTimeDifferenceS = 0.02;
// Poses come ten times a second.
constexpr double kMaxPoseGapS = 0.25;
constexpr std::string_view kPosesName = "lowres_wide.traj";

bool IsPincam(std::string_view name) { return name.ends_with(".pincam"); }

// Finer ones first.
std::string ColourFolder(const fs::path& path) {
  return FirstFolder(path, {"vga_wide", "lowres_wide", "wide"});
}

// "42445173_78.123.png" -> 78.123
std::optional<double> SecondsOf(const std::string& name) {
  const std::string stem = fs::path(name).stem().string();
  const std::size_t dash = stem.rfind('_');
  if (dash == std::string::npos) return std::nullopt;
  const std::optional<double> seconds =
      formats::ParseNumber(std::string_view(stem).substr(dash + 1));
  return seconds && std::abs(*seconds) < 1e11 ? seconds : std::nullopt;
}

std::vector<dataset::TimedFile> TimedFiles(const fs::path& capture,
                                           const std::string& folder,
                                           bool (*is_one)(std::string_view)) {
  std::vector<dataset::TimedFile> files;
  for (const std::string& name : dataset::ListFiles(capture / folder)) {
    const std::optional<double> seconds = is_one(name) ? SecondsOf(name) : std::nullopt;
    if (seconds) files.push_back({*seconds, folder + "/" + name, 0});
  }
  std::ranges::stable_sort(files, {}, &dataset::TimedFile::time_s);
  return files;
}

// The file of a time, nearest within the tolerance.
const dataset::TimedFile* NearestOf(const std::vector<dataset::TimedFile>& files, double time_s) {
  const auto after = std::ranges::lower_bound(files, time_s, {}, &dataset::TimedFile::time_s);
  const dataset::TimedFile* nearest = nullptr;
  if (after != files.end()) nearest = &*after;
  if (after != files.begin() &&
      (nearest == nullptr || time_s - (after - 1)->time_s < nearest->time_s - time_s)) {
    nearest = &*(after - 1);
  }
  const bool near = nearest != nullptr && std::abs(nearest->time_s - time_s) <= kMaxTimeDifferenceS;
  return near ? nearest : nullptr;
}

Result<PinholeCamera> ParsePincam(const std::string& text, const fs::path& file) {
  const auto n = formats::ParseNumbers(text, file, 6, "width height fx fy cx cy");
  if (!n) return n.error();
  if (!((*n)[0] >= 1 && (*n)[0] <= 16384 && (*n)[1] >= 1 && (*n)[1] <= 16384))
    return InvalidInput(fmt::format("{}: {} x {} px is no size", file.string(), (*n)[0], (*n)[1]));
  const PinholeCamera camera{
      static_cast<int>((*n)[0]), static_cast<int>((*n)[1]), (*n)[2], (*n)[3], (*n)[4], (*n)[5]};
  const Status plausible = dataset::CheckCamera(camera, file);
  if (!plausible) return plausible.error();
  return camera;
}

struct Cameras {
  std::vector<PinholeCamera> of_frames;
  std::string text;
};

Result<Cameras> ReadCameras(const fs::path& folder,
                            const std::string& intrinsics,
                            const std::vector<dataset::ImagePair>& pairs) {
  const std::vector<dataset::TimedFile> files = TimedFiles(folder, intrinsics, IsPincam);
  if (files.empty()) {
    return InvalidInput(fmt::format("{}: holds no VIDEO_SECONDS.pincam; state 'camera' in {}",
                                    (folder / intrinsics).string(),
                                    kSettingsName));
  }
  Cameras cameras;
  for (const dataset::ImagePair& pair : pairs) {
    const dataset::TimedFile* const file = NearestOf(files, pair.colour.time_s);
    if (file == nullptr) {
      return InvalidInput(fmt::format("{}: has no intrinsics within {} s of {}",
                                      (folder / intrinsics).string(),
                                      kMaxTimeDifferenceS,
                                      pair.colour.file));
    }
    const Result<std::string> text = dataset::ReadTextFile(folder / file->file);
    if (!text) return text.error();
    const Result<PinholeCamera> camera = ParsePincam(*text, folder / file->file);
    if (!camera) return camera.error();
    cameras.of_frames.push_back(*camera);
    cameras.text += *text;
  }
  return cameras;
}

Result<std::vector<formats::TimedPose>> ParseTrajectory(const std::string& text,
                                                        const fs::path& file,
                                                        std::vector<std::string>& warnings) {
  std::vector<formats::TimedPose> poses;
  formats::LineReader lines(text);
  while (const formats::TextLine* const line = lines.Next()) {
    Status read = formats::CheckFieldCount(file, *line, 7, "seconds rx ry rz tx ty tz");
    std::array<double, 7> n{};
    for (std::size_t i = 0; read && i < 7; ++i) {
      const std::optional<double> number = formats::ParseNumber(line->fields[i]);
      if (!number || !(std::abs(*number) < 1e11)) {
        read = formats::LineError(
            file,
            line->number,
            fmt::format("'{}' is not a number", formats::Shown(line->fields[i])));
      } else {
        n[i] = *number;
      }
    }
    if (!read && formats::IsLeftOut(file, *line, warnings)) break;
    if (!read) return read.error();
    const Eigen::Vector3d shift_m(n[4], n[5], n[6]);
    if (shift_m.cwiseAbs().maxCoeff() > kMaxPositionM) continue;
    const Pose3 camera_from_world{RotationFromVector({n[1], n[2], n[3]}), shift_m};
    poses.push_back({n[0], camera_from_world.Inverse(), line->number, 0});
  }
  std::ranges::stable_sort(poses, {}, &formats::TimedPose::time_s);
  return poses;
}

}  // namespace

LayoutMatch MatchArkitScenes(const fs::path& path) {
  std::error_code ignored;
  LayoutMatch match =
      MatchOfPieces({{!ColourFolder(path).empty(), "lowres_wide/ (or vga_wide/)"},
                     {fs::is_directory(path / "lowres_depth", ignored), "lowres_depth/"},
                     {fs::is_regular_file(path / kPosesName, ignored), "lowres_wide.traj"}});
  match.matches = !ColourFolder(path).empty() && fs::is_directory(path / "lowres_depth", ignored);
  return match;
}

Result<OpenedLayout> OpenArkitScenes(const LayoutSource& source) {
  const fs::path& folder = source.path;
  std::vector<std::string> warnings;
  const std::string colour = ColourFolder(folder);
  const std::vector<dataset::TimedFile> depth = TimedFiles(folder, "lowres_depth", IsDepthName);
  const std::vector<dataset::TimedFile> images = TimedFiles(folder, colour, IsColourName);
  FilesOfLayout files{"arkitscenes",
                      {},
                      formats::AssociateByTime(images, depth, kMaxTimeDifferenceS),
                      {},
                      {},
                      {},
                      {},
                      true};
  if (files.pairs.empty()) {
    return InvalidInput(
        fmt::format("{}: no image of {}/ lies within {} s of one of lowres_depth/ ({} and {} files "
                    "VIDEO_SECONDS.png)",
                    folder.string(),
                    colour,
                    kMaxTimeDifferenceS,
                    images.size(),
                    depth.size()));
  }
  PinholeCamera camera;
  if (!source.settings.has_camera()) {
    Result<Cameras> cameras = ReadCameras(folder, colour + "_intrinsics", files.pairs);
    if (!cameras) return cameras.error();
    camera = cameras->of_frames.front();
    files.optics.colour_cameras = std::move(cameras->of_frames);
    files.texts.emplace_back("cameras", cameras->text);
  }
  Result<SettledImages> settled = SettleImages(
      source, {camera, camera, Pose3(), kUnitsPerM}, files.pairs, warnings, CoarserDepth::kUsual);
  if (!settled) return settled.error();
  files.settled = *std::move(settled);
  const std::vector<dataset::TimedFile> confidence = TimedFiles(folder, "confidence", IsColourName);
  files.settled.form.min_confidence = source.settings.min_confidence.value_or(kMinConfidence);
  for (const dataset::ImagePair& pair : files.pairs) {
    const dataset::TimedFile* const sure = NearestOf(confidence, pair.depth.time_s);
    files.settled.form.confidence.push_back(sure == nullptr ? "" : sure->file);
  }
  const Result<std::optional<std::string>> text = dataset::ReadOptional(folder / kPosesName);
  if (!text) return text.error();
  files.texts.emplace_back("poses", *text);
  if (*text) {
    const Result<std::vector<formats::TimedPose>> poses =
        ParseTrajectory(**text, folder / kPosesName, warnings);
    if (!poses) return poses.error();
    for (const dataset::ImagePair& pair : files.pairs)
      files.poses.push_back(
          formats::PoseAt(*poses, pair.depth.time_s, kMaxTimeDifferenceS, kMaxPoseGapS));
    files.poses_file = (folder / kPosesName).string();
  }
  return OpenFiles(source, std::move(files), std::move(warnings));
}

}  // namespace deepslam::layouts
