// Polycam's raw data: keyframes/ with images/, depth/ (mm, coarser, seen from colour's place),
// confidence/ (0 low, 54 medium, 255 high) and cameras/ with a JSON per image: fx fy cx cy width
// height, and t_00 ... t_23, world from a camera with y up and z back. corrected_images/ and
// corrected_cameras/, which the app writes once it has closed loops, are taken where both are
// there. The number in a name is a time in microseconds.
#include <array>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "deepslam/dataset/read_bytes.h"
#include "deepslam/formats/pose_matrix.h"
#include "deepslam/layouts/image_folders.h"
#include "deepslam/layouts/open_files.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kUnitsPerM = 1000;  // millimetres, as the app exports them
constexpr int kMinConfidence = 54;   // medium

bool IsJson(std::string_view name) { return name.ends_with(".json"); }

struct Folders {
  std::string images;
  std::string cameras;
};

// Corrected ones where both are whole.
Folders FindFolders(const fs::path& folder) {
  std::error_code ignored;
  const fs::path keyframes = folder / "keyframes";
  if (fs::is_directory(keyframes / "corrected_images", ignored) &&
      fs::is_directory(keyframes / "corrected_cameras", ignored) &&
      !dataset::ListFiles(keyframes / "corrected_cameras").empty()) {
    return {"keyframes/corrected_images", "keyframes/corrected_cameras"};
  }
  return {"keyframes/images", "keyframes/cameras"};
}

struct Keyframe {
  PinholeCamera camera;
  std::optional<Pose3> world_from_camera;
};

Result<Keyframe> ParseKeyframe(const std::string& text, const fs::path& file) {
  const json root = json::parse(text, nullptr, false);
  if (!root.is_object())
    return InvalidInput(fmt::format("{}: is not a JSON object (damaged?)", file.string()));
  std::optional<Error> fault;
  const auto number = [&](const std::string& name) {
    const auto field = root.find(name);
    if (field != root.end() && field->is_number()) return field->get<double>();
    if (!fault) {
      fault =
          InvalidInput(fmt::format("{}: field '{}' is missing or no number", file.string(), name));
    }
    return 0.0;
  };
  const double width = number("width");
  const double height = number("height");
  Keyframe keyframe;
  keyframe.camera = {0, 0, number("fx"), number("fy"), number("cx"), number("cy")};
  std::array<double, 16> matrix{};
  matrix[15] = 1;
  for (std::size_t i = 0; i < 12; ++i) matrix[i] = number(fmt::format("t_{}{}", i / 4, i % 4));
  if (fault) return *fault;
  if (!(width >= 1 && width <= 16384 && height >= 1 && height <= 16384))
    return InvalidInput(fmt::format("{}: fields 'width' and 'height' are no size", file.string()));
  keyframe.camera.width = static_cast<int>(width);
  keyframe.camera.height = static_cast<int>(height);
  const Status plausible = dataset::CheckCamera(keyframe.camera, file);
  if (!plausible) return plausible.error();
  const std::optional<Pose3> pose = formats::PoseOfMatrix(matrix);
  if (pose) keyframe.world_from_camera = formats::OfOpenGlCamera(*pose);
  return keyframe;
}

struct Keyframes {
  std::vector<dataset::ImagePair> pairs;
  std::vector<Keyframe> keyframes;
  std::vector<std::string> confidence;
  std::string text;  // of all cameras, for the hash
};

Result<Keyframes> ReadKeyframes(const fs::path& folder, std::vector<std::string>& warnings) {
  const Folders folders = FindFolders(folder);
  const auto depth = FilesByNumber(folder / "keyframes/depth", IsDepthName);
  const auto confidence = FilesByNumber(folder / "keyframes/confidence", IsColourName);
  const auto cameras = FilesByNumber(folder / folders.cameras, IsJson);
  const auto images = FilesByNumber(folder / folders.images, IsColourName);
  if (!images.empty() && depth.empty()) {
    return InvalidInput(fmt::format(
        "{}: holds no depth images: captures of Polycam's photo mode have none, those of a phone "
        "with LiDAR do",
        (folder / "keyframes/depth").string()));
  }
  Keyframes read;
  for (const auto& [number, image] : images) {
    const auto own_depth = depth.find(number);
    const auto own_camera = cameras.find(number);
    if (own_depth == depth.end() || own_camera == cameras.end()) continue;
    const fs::path file = folder / folders.cameras / own_camera->second;
    const Result<std::string> text = dataset::ReadTextFile(file);
    if (!text) return text.error();
    const Result<Keyframe> keyframe = ParseKeyframe(*text, file);
    if (!keyframe) return keyframe.error();
    const double time_s = static_cast<double>(number) / 1e6;
    read.pairs.push_back({{time_s, folders.images + "/" + image, 0},
                          {time_s, "keyframes/depth/" + own_depth->second, 0}});
    read.keyframes.push_back(*keyframe);
    const auto sure = confidence.find(number);
    read.confidence.push_back(sure == confidence.end() ? ""
                                                       : "keyframes/confidence/" + sure->second);
    read.text += own_camera->second + "\n" + *text + "\n";
  }
  if (read.pairs.empty()) {
    return InvalidInput(
        fmt::format("{}: holds no image with depth and camera of one number; is the "
                    "capture unpacked completely?",
                    (folder / "keyframes").string()));
  }
  if (read.pairs.size() < images.size()) {
    warnings.push_back(fmt::format("{}: {} of {} images lack depth or a camera and are skipped",
                                   (folder / folders.images).string(),
                                   images.size() - read.pairs.size(),
                                   images.size()));
  }
  return read;
}

}  // namespace

LayoutMatch MatchPolycam(const fs::path& path) {
  std::error_code ignored;
  const Folders folders = FindFolders(path);
  LayoutMatch match =
      MatchOfPieces({{fs::is_directory(path / folders.images, ignored), "keyframes/images/"},
                     {fs::is_directory(path / "keyframes/depth", ignored), "keyframes/depth/"},
                     {fs::is_directory(path / folders.cameras, ignored), "keyframes/cameras/"}});
  match.matches = match.num_found >= 2 && fs::is_directory(path / folders.cameras, ignored);
  return match;
}

Result<OpenedLayout> OpenPolycam(const LayoutSource& source) {
  std::vector<std::string> warnings;
  Result<Keyframes> read = ReadKeyframes(source.path, warnings);
  if (!read) return read.error();
  const PinholeCamera& camera = read->keyframes.front().camera;
  Result<SettledImages> settled = SettleImages(
      source, {camera, camera, Pose3(), kUnitsPerM}, read->pairs, warnings, CoarserDepth::kUsual);
  if (!settled) return settled.error();
  settled->form.confidence = std::move(read->confidence);
  settled->form.min_confidence = source.settings.min_confidence.value_or(kMinConfidence);
  FilesOfLayout files{"polycam",
                      {{"cameras", read->text}},
                      std::move(read->pairs),
                      {},
                      (source.path / FindFolders(source.path).cameras).string(),
                      *std::move(settled),
                      {},
                      true};
  for (const Keyframe& keyframe : read->keyframes) {
    files.poses.push_back(keyframe.world_from_camera);
    files.optics.colour_cameras.push_back(keyframe.camera);
  }
  return OpenFiles(source, std::move(files), std::move(warnings));
}

}  // namespace deepslam::layouts
