// 7-Scenes (Microsoft): one folder per sequence, three files per frame. Depth in millimetres,
// 65535 where nothing was measured; poses are world from depth camera. Colour and depth are as a
// Kinect gave them: not registered, not calibrated.
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/layouts/frame_files.h"
#include "deepslam/layouts/open_files.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

constexpr double kUnitsPerM = 1000;  // millimetres, by the data set's page
// What the data set's page says of the depth camera.
constexpr PinholeCamera kKinectDepth{640, 480, 585, 585, 320, 240};
// It says nothing of the colour camera: a Kinect's usual values. It sits 25 mm to the right.
constexpr PinholeCamera kKinectColour{640, 480, 525, 525, 320, 240};
constexpr double kKinectBaselineM = 0.025;  // of the depth and colour cameras of a Kinect

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

}  // namespace

LayoutMatch MatchSevenScenes(const fs::path& path) { return MatchFrameFiles(path); }

Result<OpenedLayout> OpenSevenScenes(const LayoutSource& source) {
  const fs::path& folder = source.path;
  std::vector<std::string> warnings;
  std::vector<dataset::ImagePair> pairs = FrameFilePairs(folder);
  if (const Status there = CheckFrameFiles(folder, pairs); !there) return there.error();
  dataset::CaptureCameras cameras{kKinectColour,
                                  kKinectDepth,
                                  {Eigen::Quaterniond::Identity(), {-kKinectBaselineM, 0, 0}},
                                  kUnitsPerM};
  if (!source.settings.has_camera()) {
    const Status kinect = CheckKinect(folder, pairs);
    if (!kinect) return kinect.error();
    warnings.push_back(fmt::format(
        "{}: 7-Scenes holds no calibration; depth (585 px) is registered to colour (525 px, 25 mm "
        "beside it) by a Kinect's usual values; state 'camera' in {} if depth is registered "
        "already",
        folder.string(),
        kSettingsName));
  }
  const Result<SettledImages> settled = SettleImages(source, cameras, pairs, warnings);
  if (!settled) return settled.error();
  Result<formats::MatrixFiles> poses =
      formats::ReadMatrixFiles(folder, FramePoseNames(pairs), warnings);
  if (!poses) return poses.error();
  // Poses are those of the depth camera.
  const Pose3 depth_from_colour = settled->cameras.colour_from_depth.Inverse();
  if (!(settled->cameras.colour_from_depth == Pose3())) {
    for (std::optional<Pose3>& pose : poses->poses) {
      if (pose) pose = *pose * depth_from_colour;
    }
  }
  FilesOfLayout files{"7-scenes",
                      {{"poses", poses->text}},
                      std::move(pairs),
                      std::move(poses->poses),
                      (folder / "frame-*.pose.txt").string(),
                      *settled,
                      {},
                      false};
  return OpenFiles(source, std::move(files), std::move(warnings));
}

}  // namespace deepslam::layouts
