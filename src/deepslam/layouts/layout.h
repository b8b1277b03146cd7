// The table of capture layouts. A layout is recognised by the names of its files and opened by a
// function of its own file (`*_layout.cc`); docs/formats.md shows an example tree of each.
#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/dataset/capture_settings.h"
#include "deepslam/dataset/rectified_frames.h"
#include "deepslam/dataset/stored_frames.h"

namespace deepslam::layouts {

// What the user named, and what stands in its capture.yaml.
struct LayoutSource {
  std::filesystem::path path;         // folder, or file of layouts that are one file
  dataset::CaptureSettings settings;  // empty where nothing is stated
  std::optional<std::string> settings_text;
};

struct OpenedLayout {
  std::shared_ptr<const dataset::StoredFrames> frames;
  std::string content_hash;           // see Capture::content_hash
  std::vector<std::string> warnings;  // for the user
  std::vector<std::string> doubts;    // warnings that make every result doubtful
  bool has_times = true;              // false: the layout has none, frames are taken at 30 Hz
  dataset::Optics optics;             // what the images were taken through
  std::string poses_file;             // where poses come from, for messages
};

// How much of a layout lies in a folder.
struct LayoutMatch {
  bool matches = false;              // enough to be opened as this layout
  int num_found = 0;                 // pieces that are there
  std::vector<std::string> missing;  // pieces that are not
};

// Of pieces that all have to be there: whether each is, and what it is called.
[[nodiscard]] LayoutMatch MatchOfPieces(
    std::initializer_list<std::pair<bool, std::string_view>> pieces);

struct Layout {
  std::string_view name;    // `format` in capture.yaml
  std::string_view pieces;  // what it is recognised by, for people
  LayoutMatch (*match)(const std::filesystem::path& path);
  Result<OpenedLayout> (*open)(const LayoutSource& source);
};

// In the order in which they are tried: a layout that is a special case of another comes first.
[[nodiscard]] std::span<const Layout> Layouts();

// The layout of that name, or, when `stated` is empty, the first that matches. kInvalidInput that
// lists all layouts and what is missing for the nearest one when none does.
[[nodiscard]] Result<const Layout*> ChooseLayout(const std::filesystem::path& path,
                                                 std::string_view stated);

inline constexpr std::string_view kSettingsName = "capture.yaml";

// Camera and units that are stated win over those of the layout: `camera` alone means that depth is
// registered to it.
[[nodiscard]] dataset::CaptureCameras WithStated(const dataset::CaptureSettings& settings,
                                                 dataset::CaptureCameras cameras);

// The same for lenses, and for cameras of single frames.
[[nodiscard]] dataset::Optics WithStated(const dataset::CaptureSettings& settings,
                                         dataset::Optics optics);

// Time of a frame that is known by its number alone, at 30 Hz, in whole microseconds, which is what
// all layouts can hold.
[[nodiscard]] double TimeOfNumber(std::int64_t number);

// Warns that times are made up.
[[nodiscard]] std::string NoTimesWarning(const std::filesystem::path& path);

// The layouts, one file each.
LayoutMatch MatchTum(const std::filesystem::path& path);
Result<OpenedLayout> OpenTum(const LayoutSource& source);
LayoutMatch MatchEth3d(const std::filesystem::path& path);
Result<OpenedLayout> OpenEth3d(const LayoutSource& source);
LayoutMatch MatchIclNuim(const std::filesystem::path& path);
Result<OpenedLayout> OpenIclNuim(const LayoutSource& source);
LayoutMatch MatchSevenScenes(const std::filesystem::path& path);
Result<OpenedLayout> OpenSevenScenes(const LayoutSource& source);
LayoutMatch MatchThreeDMatch(const std::filesystem::path& path);
Result<OpenedLayout> OpenThreeDMatch(const LayoutSource& source);
LayoutMatch MatchBundleFusion(const std::filesystem::path& path);
Result<OpenedLayout> OpenBundleFusion(const LayoutSource& source);
LayoutMatch MatchThreeRScan(const std::filesystem::path& path);
Result<OpenedLayout> OpenThreeRScan(const LayoutSource& source);
LayoutMatch MatchOpen3d(const std::filesystem::path& path);
Result<OpenedLayout> OpenOpen3d(const LayoutSource& source);
LayoutMatch MatchScanNet(const std::filesystem::path& path);
Result<OpenedLayout> OpenScanNet(const LayoutSource& source);
LayoutMatch MatchScanNetExport(const std::filesystem::path& path);
Result<OpenedLayout> OpenScanNetExport(const LayoutSource& source);
LayoutMatch MatchScanNetPp(const std::filesystem::path& path);
Result<OpenedLayout> OpenScanNetPp(const LayoutSource& source);
LayoutMatch MatchStray(const std::filesystem::path& path);
Result<OpenedLayout> OpenStray(const LayoutSource& source);
LayoutMatch MatchArkitScenes(const std::filesystem::path& path);
Result<OpenedLayout> OpenArkitScenes(const LayoutSource& source);
LayoutMatch MatchPolycam(const std::filesystem::path& path);
Result<OpenedLayout> OpenPolycam(const LayoutSource& source);
LayoutMatch MatchRecord3d(const std::filesystem::path& path);
Result<OpenedLayout> OpenRecord3d(const LayoutSource& source);
LayoutMatch MatchNerfstudio(const std::filesystem::path& path);
Result<OpenedLayout> OpenNerfstudio(const LayoutSource& source);
LayoutMatch MatchReplica(const std::filesystem::path& path);
Result<OpenedLayout> OpenReplica(const LayoutSource& source);
LayoutMatch MatchHabitat(const std::filesystem::path& path);
Result<OpenedLayout> OpenHabitat(const LayoutSource& source);
LayoutMatch MatchSun3d(const std::filesystem::path& path);
Result<OpenedLayout> OpenSun3d(const LayoutSource& source);
LayoutMatch MatchRtabMap(const std::filesystem::path& path);
Result<OpenedLayout> OpenRtabMap(const LayoutSource& source);
LayoutMatch MatchRtabMapDatabase(const std::filesystem::path& path);
Result<OpenedLayout> OpenRtabMapDatabase(const LayoutSource& source);
LayoutMatch MatchFolders(const std::filesystem::path& path);
Result<OpenedLayout> OpenFolders(const LayoutSource& source);

}  // namespace deepslam::layouts
