#include "deepslam/layouts/layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "deepslam/dataset/file_frames.h"
#include "deepslam/formats/recognise_file.h"
#include "deepslam/layouts/image_folders.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

constexpr std::array<Layout, 22> kLayouts = {{
    {"3dmatch",
     "frame-000000.color.png, .depth.png, .pose.txt, camera-intrinsics.txt",
     MatchThreeDMatch,
     OpenThreeDMatch},
    {"bundlefusion",
     "frame-000000.color.jpg, .depth.png, .pose.txt, info.txt",
     MatchBundleFusion,
     OpenBundleFusion},
    {"3rscan",
     "frame-000000.color.jpg, .depth.pgm, .pose.txt, _info.txt",
     MatchThreeRScan,
     OpenThreeRScan},
    {"7-scenes",
     "frame-000000.color.png, frame-000000.depth.png, frame-000000.pose.txt",
     MatchSevenScenes,
     OpenSevenScenes},
    {"scannetpp",
     "rgb/ or rgb.mkv, depth/, pose_intrinsic_imu.json",
     MatchScanNetPp,
     OpenScanNetPp},
    {"polycam", "keyframes/ with images/, depth/, cameras/ (raw data)", MatchPolycam, OpenPolycam},
    {"arkitscenes",
     "lowres_wide/ or vga_wide/, lowres_depth/, lowres_wide.traj",
     MatchArkitScenes,
     OpenArkitScenes},
    {"replica",
     "results/frame000000.jpg, results/depth000000.png, traj.txt",
     MatchReplica,
     OpenReplica},
    {"record3d", "rgb/, depth/ (EXR), metadata.json", MatchRecord3d, OpenRecord3d},
    {"nerfstudio", "transforms.json with depth_file_path", MatchNerfstudio, OpenNerfstudio},
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
    {"scannet-export",
     "color/, depth/, pose/, intrinsic/ (ScanNet's SensReader)",
     MatchScanNetExport,
     OpenScanNetExport},
    {"sun3d", "image/, depth/, intrinsics.txt, extrinsics/", MatchSun3d, OpenSun3d},
    {"rtabmap", "NAME_rgb/, NAME_depth/, NAME_calib/ (rtabmap-export)", MatchRtabMap, OpenRtabMap},
    {"habitat", "rgb/, depth/, GT_Pose.txt", MatchHabitat, OpenHabitat},
    {"open3d",
     "color/, image/ or rgb/, depth/, camera_intrinsic.json, trajectory.log",
     MatchOpen3d,
     OpenOpen3d},
    {"scannet", "one file NAME.sens, or a folder that holds one", MatchScanNet, OpenScanNet},
    {"rtabmap-db",
     "one file NAME.db of RTAB-Map, or a folder that holds one",
     MatchRtabMapDatabase,
     OpenRtabMapDatabase},
    {"folders",
     "color/, colour/, rgb/, image/ or images/, and depth/, with capture.yaml",
     MatchFolders,
     OpenFolders},
}};

static_assert(kLayouts.size() == dataset::kFormats.size());

// Folders looked into for a capture that lies deeper, and how deep.
constexpr int kMaxFolders = 200;
constexpr int kMaxDepth = 4;  // archive, data set, scene, capture

const Layout* FirstMatch(const fs::path& path) {
  const auto found = std::ranges::find_if(
      kLayouts, [&](const Layout& layout) { return layout.match(path).matches; });
  return found == kLayouts.end() ? nullptr : &*found;
}

std::vector<fs::path> FoldersIn(const fs::path& path) {
  std::vector<fs::path> folders;
  std::error_code code;
  for (fs::directory_iterator entry(path, code), end; !code && entry != end;
       entry.increment(code)) {
    const std::string name = entry->path().filename().string();
    std::error_code ignored;
    // What macOS puts into archives.
    if (name.starts_with('.') || name == "__MACOSX" || !entry->is_directory(ignored)) continue;
    folders.push_back(entry->path());
  }
  std::ranges::sort(folders);
  return folders;
}

// Captures in folders of the folder, the nearest first.
std::vector<std::pair<fs::path, const Layout*>> CapturesBelow(const fs::path& path) {
  std::vector<std::pair<fs::path, const Layout*>> found;
  std::vector<fs::path> level = {path};
  int num_left = kMaxFolders;
  for (int depth = 0; depth < kMaxDepth && found.empty(); ++depth) {
    std::vector<fs::path> next;
    for (const fs::path& folder : level) {
      for (const fs::path& below : FoldersIn(folder)) {
        if (num_left-- <= 0) return found;
        if (const Layout* layout = FirstMatch(below)) found.emplace_back(below, layout);
        next.push_back(below);
      }
    }
    level = std::move(next);
  }
  return found;
}

std::string WhatLiesBelow(const fs::path& path) {
  const auto captures = CapturesBelow(path);
  if (captures.empty()) return {};
  std::string text = fmt::format(", but {} is one ({}): name it",
                                 captures.front().first.string(),
                                 captures.front().second->name);
  if (captures.size() > 1)
    text += fmt::format(", or one of {} more beside it", captures.size() - 1);
  return text;
}

// An archive or a recording in the folder.
std::string WhatFilesAre(const fs::path& path) {
  for (const std::string& name : dataset::ListFiles(path)) {
    const bool speaks = !IsColourName(name) && !IsDepthName(name);
    const std::optional<std::string> words =
        speaks ? formats::WhatIsToBeDone(path / name) : std::nullopt;
    if (words) return fmt::format(", but {} is {}", name, *words);
  }
  return {};
}

Error UnknownLayout(const fs::path& path) {
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
  if (const std::string below = WhatLiesBelow(path); !below.empty())
    return InvalidInput(message + below);
  if (const std::optional<std::string> words = formats::WhatIsToBeDone(path))
    return InvalidInput(fmt::format("{}, but is {}", message, *words));
  if (nearest == nullptr) message += WhatFilesAre(path);
  if (nearest != nullptr) {
    message += fmt::format("; the nearest is {}, for which is missing: {}",
                           nearest->name,
                           fmt::join(best.missing, ", "));
  }
  message += ". Known layouts (docs/formats.md shows each):";
  for (const Layout& layout : kLayouts)
    message += fmt::format("\n  {:<14} {}", layout.name, layout.pieces);
  return InvalidInput(std::move(message));
}

Error UnknownFile(const fs::path& path) {
  if (const std::optional<std::string> words = formats::WhatIsToBeDone(path))
    return InvalidInput(fmt::format("{}: {}", path.string(), *words));
  return InvalidInput(fmt::format(
      "{}: not a folder; name the folder that holds the capture, or a .sens or .db file",
      path.string()));
}

}  // namespace

std::span<const Layout> Layouts() { return kLayouts; }

LayoutMatch MatchOfPieces(std::initializer_list<std::pair<bool, std::string_view>> pieces) {
  LayoutMatch match;
  for (const auto& [found, piece] : pieces) {
    if (found) {
      ++match.num_found;
    } else {
      match.missing.emplace_back(piece);
    }
  }
  match.matches = match.missing.empty();
  return match;
}

Result<const Layout*> ChooseLayout(const fs::path& path, std::string_view stated) {
  if (!stated.empty()) {
    const auto named = std::ranges::find(kLayouts, stated, &Layout::name);
    if (named != kLayouts.end()) return &*named;
  } else if (const Layout* layout = FirstMatch(path)) {
    return layout;
  }
  std::error_code ignored;
  return fs::is_directory(path, ignored) ? UnknownLayout(path) : UnknownFile(path);
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

dataset::Optics WithStated(const dataset::CaptureSettings& settings, dataset::Optics optics) {
  if (settings.has_camera()) optics = {settings.lens, settings.lens, {}, {}};
  if (settings.depth_camera) {
    optics.depth = settings.depth_lens;
    optics.depth_cameras.clear();
  }
  return optics;
}

double TimeOfNumber(std::int64_t number) {
  return std::round(static_cast<double>(number) * 1e6 / 30.0) / 1e6;
}

std::string NoTimesWarning(const std::filesystem::path& path) {
  return fmt::format("{}: the layout has no times; frames are taken for 30 per second",
                     path.string());
}

}  // namespace deepslam::layouts
