// Replica as rendered for iMAP and NICE-SLAM: results/frame000000.jpg and results/depth000000.png,
// traj.txt with a matrix per frame (world from camera, axes x right, y down, z forward), and
// cam_params.json here or in the folder above, with the camera and depth's units (6553.5).
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "deepslam/dataset/read_bytes.h"
#include "deepslam/layouts/image_folders.h"
#include "deepslam/layouts/open_files.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::string_view kImages = "results";
constexpr std::string_view kPosesName = "traj.txt";
constexpr std::string_view kCameraName = "cam_params.json";
// Of all captures of that rendering.
constexpr PinholeCamera kRendered{1200, 680, 600, 600, 599.5, 339.5};
constexpr double kRenderedUnitsPerM = 6553.5;  // 'scale' of its cam_params.json: 10 m in 16 bits

bool IsNamed(std::string_view name, std::string_view begin) {
  return name.starts_with(begin) && name.size() > begin.size() && name[begin.size()] >= '0' &&
         name[begin.size()] <= '9';
}
bool IsColour(std::string_view name) { return IsNamed(name, "frame") && IsColourName(name); }
bool IsDepth(std::string_view name) { return IsNamed(name, "depth") && IsDepthName(name); }

// Images of one number; the position of a frame among all is that of its pose.
std::vector<dataset::ImagePair> PairsOf(const fs::path& folder) {
  std::map<std::int64_t, std::string> depth;
  for (const NumberedImage& image : ListImages(folder, std::string(kImages), IsDepth)) {
    if (image.number) depth.emplace(*image.number, image.file);
  }
  std::vector<dataset::ImagePair> pairs;
  for (const NumberedImage& image : ListImages(folder, std::string(kImages), IsColour)) {
    const auto found = image.number ? depth.find(*image.number) : depth.end();
    if (found == depth.end()) continue;
    const double time_s = TimeOfNumber(*image.number);
    pairs.push_back({{time_s, image.file, 0}, {time_s, found->second, 0}});
  }
  return pairs;
}

std::optional<fs::path> FindCamera(const fs::path& folder) {
  std::error_code code;
  const fs::path full = fs::weakly_canonical(folder, code);
  for (const fs::path& place : {folder, (code ? folder : full).parent_path()}) {
    if (fs::is_regular_file(place / kCameraName, code)) return place / kCameraName;
  }
  return std::nullopt;
}

struct Camera {
  PinholeCamera camera = kRendered;
  double units_per_m = kRenderedUnitsPerM;
  std::string text;
};

Result<Camera> ReadCamera(const fs::path& file) {
  Result<std::string> text = dataset::ReadTextFile(file);
  if (!text) return text.error();
  const json root = json::parse(*text, nullptr, false);
  const json& camera = root.is_object() && root.contains("camera") ? root["camera"] : root;
  Camera read;
  read.text = *text;
  double width = 0, height = 0;
  for (const auto& [name, target] : {std::pair("w", &width),
                                     {"h", &height},
                                     {"fx", &read.camera.fx},
                                     {"fy", &read.camera.fy},
                                     {"cx", &read.camera.cx},
                                     {"cy", &read.camera.cy},
                                     {"scale", &read.units_per_m}}) {
    const auto field = camera.is_object() ? camera.find(name) : camera.end();
    if (field == camera.end() || !field->is_number()) {
      return InvalidInput(fmt::format(
          "{}: field 'camera.{}' is missing or no number; a complete file reads {{\"camera\": "
          "{{\"w\": 1200, \"h\": 680, \"fx\": 600, \"fy\": 600, \"cx\": 599.5, \"cy\": 339.5, "
          "\"scale\": 6553.5}}}}",
          file.string(),
          name));
    }
    *target = field->get<double>();
  }
  if (!(width >= 1 && width <= 16384 && height >= 1 && height <= 16384))
    return InvalidInput(
        fmt::format("{}: field 'camera.w' or 'camera.h' is {} x {}", file.string(), width, height));
  if (!(read.units_per_m >= 1 && read.units_per_m <= 1e6)) {
    return InvalidInput(fmt::format(
        "{}: field 'camera.scale' is {}, outside 1 .. 1000000", file.string(), read.units_per_m));
  }
  read.camera.width = static_cast<int>(width);
  read.camera.height = static_cast<int>(height);
  const Status plausible = dataset::CheckCamera(read.camera, file);
  if (!plausible) return plausible.error();
  return read;
}

Result<Camera> CameraOf(const LayoutSource& source,
                        const std::vector<dataset::ImagePair>& pairs,
                        std::vector<std::string>& warnings) {
  if (const std::optional<fs::path> file = FindCamera(source.path)) return ReadCamera(*file);
  if (source.settings.has_camera()) return Camera();
  const Result<dataset::ImageSize> size = FirstColourSize(source.path, pairs);
  if (!size) return size.error();
  if (size->width != kRendered.width || size->height != kRendered.height) {
    return InvalidInput(fmt::format("{}: missing, so the camera is unknown; state 'camera' in {}",
                                    (source.path / kCameraName).string(),
                                    kSettingsName));
  }
  warnings.push_back(fmt::format(
      "{}: missing; taken for the camera of all captures rendered so (1200 x 680, 600 px, depth of "
      "6553.5 a metre)",
      (source.path / kCameraName).string()));
  return Camera();
}

}  // namespace

LayoutMatch MatchReplica(const fs::path& path) {
  std::error_code ignored;
  const bool has_images = fs::is_directory(path / kImages, ignored) && !PairsOf(path).empty();
  LayoutMatch match =
      MatchOfPieces({{has_images, "results/frame000000.jpg, results/depth000000.png"},
                     {fs::is_regular_file(path / kPosesName, ignored), "traj.txt"}});
  match.matches = has_images;
  return match;
}

Result<OpenedLayout> OpenReplica(const LayoutSource& source) {
  const fs::path& folder = source.path;
  std::vector<std::string> warnings;
  std::vector<dataset::ImagePair> pairs = PairsOf(folder);
  if (pairs.empty()) {
    return InvalidInput(fmt::format("{}: holds no frame000000.jpg and depth000000.png",
                                    (folder / kImages).string()));
  }
  const Result<Camera> camera = CameraOf(source, pairs, warnings);
  if (!camera) return camera.error();
  const Result<SettledImages> settled = SettleImages(
      source, {camera->camera, camera->camera, Pose3(), camera->units_per_m}, pairs, warnings);
  if (!settled) return settled.error();
  const Result<std::optional<std::string>> text = dataset::ReadOptional(folder / kPosesName);
  if (!text) return text.error();
  formats::FramePoses poses(pairs.size());
  if (*text) {
    Result<formats::FramePoses> all = formats::ParsePoseLines(
        **text, folder / kPosesName, formats::PoseColumns::kMatrix, warnings);
    if (!all) return all.error();
    if (all->size() != pairs.size()) {
      warnings.push_back(
          fmt::format("{}: has {} poses, there are {} frames; frames without one "
                      "have none",
                      (folder / kPosesName).string(),
                      all->size(),
                      pairs.size()));
    }
    for (std::size_t i = 0; i < std::min(poses.size(), all->size()); ++i) poses[i] = (*all)[i];
  }
  FilesOfLayout files{"replica",
                      {{"camera", camera->text}, {"poses", *text}},
                      std::move(pairs),
                      std::move(poses),
                      (folder / kPosesName).string(),
                      *settled,
                      {},
                      false};
  return OpenFiles(source, std::move(files), std::move(warnings));
}

}  // namespace deepslam::layouts
