#include "deepslam/layouts/suggest_settings.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <optional>

#include <fmt/format.h>

#include "deepslam/dataset/doubts.h"
#include "deepslam/dataset/image_files.h"
#include "deepslam/layouts/image_folders.h"
#include "deepslam/layouts/settle_images.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

// Focal lengths over the longer side: PrimeSense's and Kinect's colour (525 of 640), what phones
// record their LiDAR's depth with (1430 of 1920), and in between.
constexpr double kKinectsFocal = 525.0 / 640;
constexpr double kPhonesFocal = 0.745;  // 1430 of 1920
constexpr double kUsualFocal = 0.8;     // off by 2 and 7 % from the two above
// Of the longer side of an iPhone's depth.
constexpr int kPhonesDepthPx = 256;
// Raw depth of one metre, most usual first (millimetres, TUM's, Habitat scripts').
constexpr std::array<double, 3> kUnitsPerM = {1000, 5000, 6553.5};

double FocalShare(const dataset::ImageSize& colour, const dataset::DepthFileKind& depth) {
  if (std::max(depth.width, depth.height) == kPhonesDepthPx) return kPhonesFocal;
  if (colour.width == 640 && colour.height == 480) return kKinectsFocal;
  return kUsualFocal;
}

PinholeCamera CameraOf(const dataset::ImageSize& size, double focal_share) {
  const double focal_px = focal_share * std::max(size.width, size.height);
  return {
      size.width, size.height, focal_px, focal_px, 0.5 * (size.width - 1), 0.5 * (size.height - 1)};
}

// The median of what was measured; nothing where no image can be read.
std::optional<double> MedianRaw(const fs::path& folder,
                                const std::vector<dataset::ImagePair>& pairs,
                                const dataset::DepthFileKind& kind) {
  for (const dataset::ImagePair& pair : pairs) {
    const Result<RawDepthImage> depth =
        dataset::ReadDepthFile(folder / pair.depth.file, kind.width, kind.height);
    if (!depth) continue;
    std::vector<std::uint16_t> values;
    std::ranges::copy_if(*depth, std::back_inserter(values), [](std::uint16_t raw) {
      return raw != kNoDepth && raw != kSaturatedDepth;
    });
    if (values.empty()) continue;
    std::ranges::nth_element(values,
                             values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
    return values[values.size() / 2];
  }
  return std::nullopt;
}

double UnitsOf(std::optional<double> median_raw) {
  if (!median_raw) return kUnitsPerM.front();
  const auto* const fitting = std::ranges::find_if(kUnitsPerM, [&](double units_per_m) {
    return *median_raw >= dataset::kNearestMedianM * units_per_m &&
           *median_raw <= dataset::kFarthestMedianM * units_per_m;
  });
  return fitting == kUnitsPerM.end() ? kUnitsPerM.front() : *fitting;
}

}  // namespace

Result<dataset::CaptureSettings> SuggestSettings(const fs::path& folder) {
  const std::string colour = FirstFolder(folder, {"color", "colour", "rgb", "image", "images"});
  if (colour.empty()) {
    return InvalidInput(
        fmt::format("{}: holds none of color/, colour/, rgb/, image/, images/", folder.string()));
  }
  std::vector<std::string> warnings;
  const Result<FolderPairs> read = PairFolders(folder, colour, "depth", warnings);
  if (!read) return read.error();
  const Result<dataset::ImageSize> size = FirstColourSize(folder, read->pairs);
  if (!size) return size.error();
  const Result<dataset::DepthFileKind> kind = FirstDepthKind(folder, read->pairs);
  if (!kind) return kind.error();
  dataset::CaptureSettings settings;
  settings.format = "folders";
  const double focal_share = FocalShare(*size, *kind);
  settings.camera = CameraOf(*size, focal_share);
  settings.assumed = {"camera"};
  if (!kind->real) {
    settings.depth_units_per_m = UnitsOf(MedianRaw(folder, read->pairs, *kind));
    settings.assumed.emplace_back("depth_units_per_m");
  }
  const dataset::ImageSize depth_size{kind->width, kind->height};
  if (SameView(settings.camera, depth_size, folder)) return settings;
  settings.depth_camera = CameraOf(depth_size, focal_share);
  settings.colour_from_depth = Pose3();
  settings.assumed.emplace_back("depth_camera");
  settings.assumed.emplace_back("colour_from_depth");
  return settings;
}

Status WriteSuggestedSettings(const fs::path& folder, const dataset::CaptureSettings& settings) {
  const fs::path file = folder / kSettingsName;
  std::error_code ignored;
  if (fs::exists(fs::symlink_status(file, ignored))) {
    return InvalidInput(
        fmt::format("{}: exists already and was left as it is; rename it to have "
                    "one written",
                    file.string()));
  }
  std::ofstream out(file, std::ios::binary);
  out << "# Written by deepslam doctor. What stands in 'assumed' nobody has stated: put your "
         "camera's values\n# there, and take each field that you have confirmed out of the list.\n"
      << dataset::FormatCaptureSettings(settings);
  out.close();
  if (!out) return Failed(fmt::format("{}: cannot be written (rights? disk full?)", file.string()));
  return Ok();
}

}  // namespace deepslam::layouts
