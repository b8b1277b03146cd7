#include "deepslam/convert/other_files.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace deepslam::convert {
namespace {

// Of any layout.
constexpr std::array<std::string_view, 40> kKnown = {"rgb",
                                                     "depth",
                                                     "color",
                                                     "image",
                                                     "confidence",
                                                     "rgb.txt",
                                                     "depth.txt",
                                                     "associations.txt",
                                                     "associated.txt",
                                                     "groundtruth.txt",
                                                     "calibration.txt",
                                                     "capture.yaml",
                                                     "conversion.json",
                                                     "camera_intrinsic.json",
                                                     "intrinsic.json",
                                                     "config.json",
                                                     "trajectory.log",
                                                     "odometry.csv",
                                                     "camera_matrix.csv",
                                                     "rgb.mp4",
                                                     "colour",
                                                     "images",
                                                     "pose",
                                                     "poses",
                                                     "pose.txt",
                                                     "poses.txt",
                                                     "intrinsic",
                                                     "results",
                                                     "traj.txt",
                                                     "keyframes",
                                                     "transforms.json",
                                                     "metadata.json",
                                                     "GT_Pose.txt",
                                                     "pose_intrinsic_imu.json",
                                                     "intrinsics.txt",
                                                     "extrinsics",
                                                     "camera-intrinsics.txt",
                                                     "info.txt",
                                                     "_info.txt",
                                                     "cam_params.json"};

bool IsKnown(std::string_view name) {
  return std::ranges::find(kKnown, name) != kKnown.end() || name.starts_with("frame-") ||
         name.ends_with(".sens") || name.ends_with(".gt.freiburg") || name.ends_with(".log") ||
         name.starts_with("lowres_") || name.starts_with("vga_wide") || name.ends_with(".db") ||
         name.starts_with('.');
}

}  // namespace

std::vector<std::string> OtherFiles(const std::filesystem::path& folder) {
  std::vector<std::string> others;
  std::error_code code;
  for (std::filesystem::directory_iterator entry(folder, code), end; !code && entry != end;
       entry.increment(code)) {
    std::string name = entry->path().filename().string();
    if (!IsKnown(name)) others.push_back(std::move(name));
  }
  std::ranges::sort(others);
  return others;
}

}  // namespace deepslam::convert
