#include "deepslam/layouts/settle_images.h"

#include <cmath>
#include <optional>

#include <fmt/format.h>

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

// Whole pixels of small images are rounded by as much; other shapes differ by a tenth and more.
constexpr double kSameShape = 0.02;

bool SameShape(double width, double height, double other_width, double other_height) {
  return std::abs(width * other_height / (height * other_width) - 1) <= kSameShape;
}

template <typename T, typename Read>
Result<T> FirstRead(const fs::path& folder,
                    const std::vector<dataset::ImagePair>& pairs,
                    dataset::TimedFile dataset::ImagePair::*image,
                    const Read& read) {
  std::optional<Error> first_error;
  for (const dataset::ImagePair& pair : pairs) {
    const Result<T> value = read(folder / (pair.*image).file);
    if (value) return value;
    if (!first_error) first_error = value.error();
  }
  return first_error.value_or(InvalidInput(fmt::format("{}: holds no images", folder.string())));
}

}  // namespace

Result<PinholeCamera> SameView(const PinholeCamera& camera,
                               const dataset::ImageSize& size,
                               const fs::path& file) {
  const auto refused = [&](std::string_view what) {
    return InvalidInput(fmt::format("{}: is {} x {} px, colour {} x {}: {}",
                                    file.string(),
                                    size.width,
                                    size.height,
                                    camera.width,
                                    camera.height,
                                    what));
  };
  if (SameShape(camera.width, camera.height, size.height, size.width) &&
      !SameShape(camera.width, camera.height, size.width, size.height)) {
    return refused(
        "one lies on its side against the other (colour extracted by ffmpeg with its rotation? Use "
        "-noautorotate, or give the video itself)");
  }
  if (!SameShape(camera.width, camera.height, size.width, size.height)) {
    return refused(
        "of another shape, so not the same view; state 'depth_camera' and 'colour_from_depth' in "
        "capture.yaml, or register depth to colour first (k4a_transformation, rs-align)");
  }
  const double sx = static_cast<double>(size.width) / camera.width;
  const double sy = static_cast<double>(size.height) / camera.height;
  return PinholeCamera{size.width,
                       size.height,
                       camera.fx * sx,
                       camera.fy * sy,
                       (camera.cx + 0.5) * sx - 0.5,
                       (camera.cy + 0.5) * sy - 0.5};
}

Result<dataset::ImageSize> FirstColourSize(const fs::path& folder,
                                           const std::vector<dataset::ImagePair>& pairs) {
  return FirstRead<dataset::ImageSize>(
      folder, pairs, &dataset::ImagePair::colour, dataset::ReadImageSize);
}

Result<dataset::DepthFileKind> FirstDepthKind(const fs::path& folder,
                                              const std::vector<dataset::ImagePair>& pairs) {
  return FirstRead<dataset::DepthFileKind>(
      folder, pairs, &dataset::ImagePair::depth, dataset::ReadDepthKind);
}

Result<SettledImages> SettleImages(const LayoutSource& source,
                                   const dataset::CaptureCameras& of_layout,
                                   const std::vector<dataset::ImagePair>& pairs,
                                   std::vector<std::string>& warnings,
                                   CoarserDepth coarser) {
  SettledImages settled{WithStated(source.settings, of_layout), {}};
  dataset::CaptureCameras& cameras = settled.cameras;
  const Result<dataset::DepthFileKind> kind = FirstDepthKind(source.path, pairs);
  if (!kind) return settled;  // nothing is readable: told when frames are looked at
  if (kind->real) {
    const double stated = source.settings.depth_units_per_m;
    settled.form.raw_per_real = dataset::kRealDepthUnitsPerM / (stated > 0 ? stated : 1);
    cameras.depth_units_per_m = dataset::kRealDepthUnitsPerM;
  } else if (!(cameras.depth_units_per_m > 0)) {
    return InvalidInput(fmt::format(
        "{}: missing, or without 'depth_units_per_m': what depth of one metre is in the images is "
        "not known (most cameras: 1000, TUM: 5000); state it there",
        (source.path / kSettingsName).string()));
  }
  const bool of_size = kind->width == cameras.depth.width && kind->height == cameras.depth.height;
  if (of_size || source.settings.depth_camera || !cameras.registered()) return settled;
  const fs::path file = source.path / pairs.front().depth.file;
  const Result<PinholeCamera> depth = SameView(cameras.colour, {kind->width, kind->height}, file);
  if (!depth) return depth.error();
  cameras.depth = *depth;
  if (coarser == CoarserDepth::kUsual) return settled;
  warnings.push_back(fmt::format(
      "{}: depth of {} x {} px is taken for colour's view of {} x {}; where it has a camera of its "
      "own, state 'depth_camera' and 'colour_from_depth' in capture.yaml",
      file.string(),
      kind->width,
      kind->height,
      cameras.colour.width,
      cameras.colour.height));
  return settled;
}

}  // namespace deepslam::layouts
