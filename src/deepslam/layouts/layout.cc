#include "deepslam/layouts/layout.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace deepslam::layouts {
namespace {

constexpr std::array<Layout, 7> kLayouts = {{
    {"7-scenes",
     "frame-000000.color.png, frame-000000.depth.png, frame-000000.pose.txt",
     MatchSevenScenes,
     OpenSevenScenes},
    {"stray",
     "rgb.mp4 or rgb/, depth/000000.png, odometry.csv, camera_matrix.csv",
     MatchStray,
     OpenStray},
    {"icl-nuim",
     "rgb/0.png, depth/0.png, associations.txt (depth first), NAME.gt.freiburg",
     MatchIclNuim,
     OpenIclNuim},
    {"eth3d",
     "rgb.txt and depth.txt, or associated.txt, with calibration.txt",
     MatchEth3d,
     OpenEth3d},
    {"tum", "rgb.txt and depth.txt, or associations.txt, with capture.yaml", MatchTum, OpenTum},
    {"open3d",
     "color/, image/ or rgb/, depth/, camera_intrinsic.json, trajectory.log",
     MatchOpen3d,
     OpenOpen3d},
    {"scannet", "one file NAME.sens, or a folder that holds one", MatchScanNet, OpenScanNet},
}};

static_assert(kLayouts.size() == dataset::kFormats.size());

Error UnknownLayout(const std::filesystem::path& path) {
  const Layout* nearest = nullptr;
  LayoutMatch best;
  for (const Layout& layout : kLayouts) {
    const LayoutMatch match = layout.match(path);
    const bool better = match.num_found > best.num_found ||
                        (match.num_found == best.num_found && nearest != nullptr &&
                         match.missing.size() < best.missing.size());
    if (match.num_found == 0 || !better) continue;
    nearest = &layout;
    best = match;
  }
  std::string message = fmt::format("{}: holds no capture in a known layout", path.string());
  if (nearest != nullptr) {
    message += fmt::format("; the nearest is {}, for which is missing: {}",
                           nearest->name,
                           fmt::join(best.missing, ", "));
  }
  message += ". Known layouts (docs/formats.md shows each):";
  for (const Layout& layout : kLayouts)
    message += fmt::format("\n  {:<9} {}", layout.name, layout.pieces);
  return InvalidInput(std::move(message));
}

}  // namespace

std::span<const Layout> Layouts() { return kLayouts; }

Result<const Layout*> ChooseLayout(const std::filesystem::path& path, std::string_view stated) {
  for (const Layout& layout : kLayouts) {
    if (stated.empty() ? layout.match(path).matches : layout.name == stated) return &layout;
  }
  return UnknownLayout(path);
}

dataset::CaptureCameras WithStated(const dataset::CaptureSettings& settings,
                                   dataset::CaptureCameras cameras) {
  if (settings.has_camera()) {
    cameras.colour = settings.camera;
    cameras.depth = settings.camera;
    cameras.colour_from_depth = Pose3();
  }
  if (settings.depth_camera) cameras.depth = *settings.depth_camera;
  if (settings.colour_from_depth) cameras.colour_from_depth = *settings.colour_from_depth;
  if (settings.depth_units_per_m > 0) cameras.depth_units_per_m = settings.depth_units_per_m;
  return cameras;
}

double TimeOfNumber(std::int64_t number) {
  return std::round(static_cast<double>(number) * 1e6 / 30.0) / 1e6;
}

std::string NoTimesWarning(const std::filesystem::path& path) {
  return fmt::format("{}: the layout has no times; frames are taken for 30 per second",
                     path.string());
}

}  // namespace deepslam::layouts
