// Folders of Open3D's reconstruction system and of the Redwood data sets: colour in color/, image/
// or rgb/, depth in depth/ (raw 1000 per metre unless config.json says `depth_scale`), intrinsics
// as JSON with the matrix column by column, trajectory.log with world from camera.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "deepslam/dataset/file_frames.h"
#include "deepslam/dataset/read_bytes.h"
#include "deepslam/formats/pose_matrix.h"
#include "deepslam/formats/pose_texts.h"
#include "deepslam/formats/text_lines.h"
#include "deepslam/layouts/depth_scale.h"
#include "deepslam/layouts/image_folders.h"
#include "deepslam/layouts/layout.h"
#include "deepslam/layouts/settle_images.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kUnitsPerM = 1000;  // millimetres: Open3D's default depth_scale
// PrimeSense's, which Open3D takes when nothing is stated.
constexpr PinholeCamera kDefaultCamera{640, 480, 525, 525, 319.5, 239.5};
constexpr std::array kIntrinsicNames = {"camera_intrinsic.json", "intrinsic.json"};
constexpr std::string_view kConfigName = "config.json";

Error JsonError(const fs::path& file, std::string_view fault) {
  return InvalidInput(fmt::format(
      "{}: {}; a complete file reads {{\"width\": 640, \"height\": 480, \"intrinsic_matrix\": [fx, "
      "0, 0, 0, fy, 0, cx, cy, 1]}} (column by column)",
      file.string(),
      fault));
}

struct Intrinsics {
  PinholeCamera camera;
  std::optional<double> depth_scale;
};

Status ParseSize(const json& root, const fs::path& file, PinholeCamera& camera) {
  for (const auto& [name, target] :
       {std::pair("width", &camera.width), {"height", &camera.height}}) {
    const auto field = root.find(name);
    if (field == root.end() || !field->is_number())
      return JsonError(file, fmt::format("field '{}' is missing or no number", name));
    const double value = field->get<double>();
    if (!(value >= 1 && value <= 1e6))
      return JsonError(file, fmt::format("field '{}' is {}", name, value));
    *target = static_cast<int>(value);
  }
  return Ok();
}

Result<Intrinsics> ParseIntrinsics(const std::string& text,
                                   const fs::path& file,
                                   std::vector<std::string>& warnings) {
  const json root = json::parse(text, nullptr, false);
  if (!root.is_object()) return JsonError(file, "is not a JSON object");
  Intrinsics intrinsics;
  PinholeCamera& camera = intrinsics.camera;
  if (const Status size = ParseSize(root, file, camera); !size) return size.error();
  const auto matrix = root.find("intrinsic_matrix");
  if (matrix == root.end() || !matrix->is_array() || matrix->size() != 9 ||
      !std::all_of(matrix->begin(), matrix->end(), [](const json& n) { return n.is_number(); })) {
    return JsonError(file, "field 'intrinsic_matrix' is not a list of 9 numbers");
  }
  std::array<double, 9> m{};
  for (std::size_t i = 0; i < 9; ++i) m[i] = (*matrix)[i].get<double>();
  if (m[6] == 0 && m[7] == 0 && (m[2] != 0 || m[5] != 0)) {
    warnings.push_back(fmt::format(
        "{}: 'intrinsic_matrix' is written row by row, Open3D's is column by column; it was read "
        "as meant (cx {}, cy {})",
        file.string(),
        m[2],
        m[5]));
    std::swap(m[2], m[6]);
    std::swap(m[5], m[7]);
  }
  camera.fx = m[0];
  camera.fy = m[4];
  camera.cx = m[6];
  camera.cy = m[7];
  const Status plausible = dataset::CheckCamera(camera, file);
  if (!plausible) return plausible.error();
  const Result<std::optional<double>> scale = FindDepthScale(text, file, warnings);
  if (!scale) return scale.error();
  intrinsics.depth_scale = *scale;
  return intrinsics;
}

struct Config {
  std::optional<std::string> intrinsics;  // file
  std::optional<double> depth_scale;
};

Result<Config> ParseConfig(const std::optional<std::string>& text,
                           const fs::path& file,
                           std::vector<std::string>& warnings) {
  Config config;
  if (!text) return config;
  const json root = json::parse(*text, nullptr, false);
  if (!root.is_object())
    return InvalidInput(
        fmt::format("{}: is not a JSON object; correct or remove it", file.string()));
  if (const auto field = root.find("path_intrinsic");
      field != root.end() && field->is_string() && !field->get<std::string>().empty()) {
    config.intrinsics = field->get<std::string>();
  }
  const Result<std::optional<double>> scale = FindDepthScale(*text, file, warnings);
  if (!scale) return scale.error();
  config.depth_scale = *scale;
  return config;
}

// The intrinsics' file: by one of its usual names, or where config.json says.
std::optional<fs::path> FindIntrinsics(const fs::path& folder, const Config& config) {
  std::error_code ignored;
  for (const char* name : kIntrinsicNames) {
    if (fs::is_regular_file(folder / name, ignored)) return folder / name;
  }
  if (config.intrinsics) {
    const fs::path named = folder / fs::path(*config.intrinsics).filename();
    if (fs::is_regular_file(named, ignored)) return named;
  }
  return std::nullopt;
}

// trajectory.log, or the only other .log file.
Result<std::optional<fs::path>> FindTrajectory(const fs::path& folder,
                                               std::vector<std::string>& warnings) {
  std::error_code ignored;
  if (fs::is_regular_file(folder / "trajectory.log", ignored)) return {folder / "trajectory.log"};
  std::vector<std::string> logs;
  for (std::string& name : dataset::ListFiles(folder)) {
    if (name.ends_with(".log")) logs.push_back(std::move(name));
  }
  if (logs.size() == 1) return {folder / logs.front()};
  if (logs.size() > 1) {
    warnings.push_back(fmt::format(
        "{}: holds several trajectories ({}) and none called trajectory.log; none was read",
        folder.string(),
        fmt::join(logs, ", ")));
  }
  return std::optional<fs::path>();
}

// One block of five lines from `begin` on.
struct LoggedPose {
  std::size_t frame = 0;
  std::optional<Pose3> world_from_camera;
};

Result<LoggedPose> ParseLoggedPose(const std::vector<formats::TextLine>& lines,
                                   std::size_t begin,
                                   const fs::path& file,
                                   std::size_t num_frames) {
  const formats::TextLine& head = lines[begin];
  const std::optional<std::int64_t> index =
      head.fields.size() == 3 ? WholeNumber(head.fields[0]) : std::nullopt;
  if (!index) {
    return formats::LineError(
        file, head.number, "expected the line 'i j n' of a pose (three whole numbers)");
  }
  if (*index >= static_cast<std::int64_t>(num_frames)) {
    return formats::LineError(
        file,
        head.number,
        fmt::format(
            "is the pose of frame {}, the capture has {} colour images", *index, num_frames));
  }
  std::array<double, 16> matrix{};
  for (std::size_t row = 0; row < 4; ++row) {
    if (begin + 1 + row >= lines.size())
      return formats::LineError(file, head.number, "the file ends within this pose (truncated?)");
    const formats::TextLine& line = lines[begin + 1 + row];
    const Status count = formats::CheckFieldCount(file, line, 4, "a row of a 4 x 4 matrix");
    if (!count) return count.error();
    for (std::size_t column = 0; column < 4; ++column) {
      const std::optional<double> number = formats::ParseNumber(line.fields[column]);
      if (!number) {
        return formats::LineError(
            file,
            line.number,
            fmt::format("'{}' is not a number", formats::Shown(line.fields[column])));
      }
      matrix[4 * row + column] = *number;
    }
  }
  return LoggedPose{static_cast<std::size_t>(*index), formats::PoseOfMatrix(matrix)};
}

// Blocks of five lines: `i j n`, then world from camera, row by row. i is the frame's index. A last
// block that the file ends within is left out where others stand before it.
Result<formats::FramePoses> ParseTrajectory(const std::string& text,
                                            const fs::path& file,
                                            std::size_t num_frames,
                                            std::vector<std::string>& warnings) {
  formats::FramePoses poses(num_frames);
  const std::vector<formats::TextLine> lines = formats::SplitLines(text);
  std::size_t num_unusable = 0;
  for (std::size_t begin = 0; begin < lines.size(); begin += 5) {
    const Result<LoggedPose> pose = ParseLoggedPose(lines, begin, file, num_frames);
    const bool is_last = begin + 5 >= lines.size();
    const bool ends_within = begin + 5 > lines.size() || lines.back().unfinished;
    if (!pose && is_last && ends_within && begin > 0) {
      warnings.push_back(fmt::format("{}; the last pose was left out (was the recorder stopped?)",
                                     pose.error().message));
      break;
    }
    if (!pose) return pose.error();
    poses[pose->frame] = pose->world_from_camera;
    if (!pose->world_from_camera) ++num_unusable;
  }
  if (num_unusable > 0) {
    warnings.push_back(fmt::format("{}: {} poses are not finite or no rotations and were left out",
                                   file.string(),
                                   num_unusable));
  }
  return poses;
}

std::string ColourFolder(const fs::path& path) {
  return FirstFolder(path, {"color", "image", "rgb"});
}

// "0000001-000000033369.jpg": images of the Redwood data sets.
bool HasRedwoodNames(const fs::path& folder, const std::string& colour_folder) {
  if (colour_folder.empty()) return false;
  const std::vector<NumberedImage> images = ListImages(folder, colour_folder, IsColourName);
  return !images.empty() && images.front().time_us.has_value();
}

struct CameraOfFolder {
  Intrinsics intrinsics;
  std::optional<std::string> text;  // of their file
};

// From their file; else PrimeSense's, unless capture.yaml states a camera.
Result<CameraOfFolder> ReadCamera(const LayoutSource& source,
                                  const Config& config,
                                  const std::vector<dataset::ImagePair>& pairs,
                                  std::vector<std::string>& warnings) {
  const fs::path& folder = source.path;
  CameraOfFolder camera{{kDefaultCamera, std::nullopt}, std::nullopt};
  if (const std::optional<fs::path> file = FindIntrinsics(folder, config)) {
    Result<std::string> text = dataset::ReadTextFile(*file);
    if (!text) return text.error();
    const Result<Intrinsics> parsed = ParseIntrinsics(*text, *file, warnings);
    if (!parsed) return parsed.error();
    camera.intrinsics = *parsed;
    camera.text = *std::move(text);
    return camera;
  }
  if (source.settings.has_camera()) return camera;
  if (const std::string other = FileOfCamera(folder); !other.empty()) {
    return InvalidInput(fmt::format(
        "{}: seems to tell of the camera, but is not read in this layout (read are {}); "
        "write its values as 'camera' to {}",
        (folder / other).string(),
        fmt::join(kIntrinsicNames, ", "),
        (folder / kSettingsName).string()));
  }
  const Result<dataset::ImageSize> size = FirstColourSize(folder, pairs);
  if (size && (size->width != kDefaultCamera.width || size->height != kDefaultCamera.height)) {
    return JsonError(folder / kIntrinsicNames[0],
                     "is missing, so the camera's intrinsics are unknown");
  }
  warnings.push_back(fmt::format(
      "{}: missing; taken for the PrimeSense camera that Open3D takes by default (640 x 480, 525 "
      "px)",
      (folder / kIntrinsicNames[0]).string()));
  return camera;
}

// Of config.json or of the intrinsics.
Result<double> DepthScale(const fs::path& folder,
                          const Config& config,
                          const Intrinsics& intrinsics,
                          std::vector<std::string>& warnings) {
  if (config.depth_scale && intrinsics.depth_scale) {
    // A camera's own scale is a 32-bit number near a whole one: 3999.999756.
    if (std::abs(*config.depth_scale / *intrinsics.depth_scale - 1) > 1e-3) {
      return InvalidInput(
          fmt::format("{}: 'depth_scale' is {}, in the intrinsics' file {}: remove the wrong one",
                      (folder / kConfigName).string(),
                      *config.depth_scale,
                      *intrinsics.depth_scale));
    }
    return *config.depth_scale;
  }
  if (!intrinsics.depth_scale) return config.depth_scale.value_or(kUnitsPerM);
  if (*intrinsics.depth_scale != kUnitsPerM) {
    warnings.push_back(
        fmt::format("{}: 'depth_scale' of the intrinsics' file, {}, is taken for the "
                    "raw depth of one metre",
                    folder.string(),
                    *intrinsics.depth_scale));
  }
  return *intrinsics.depth_scale;
}

}  // namespace

LayoutMatch MatchOpen3d(const fs::path& path) {
  std::error_code ignored;
  const bool has_colour = !ColourFolder(path).empty();
  const bool has_depth = fs::is_directory(path / "depth", ignored);
  const bool has_intrinsics = FindIntrinsics(path, {}).has_value();
  const bool has_log = fs::exists(path / "trajectory.log", ignored);
  LayoutMatch match = MatchOfPieces({{has_colour, "color/ (or image/, rgb/)"},
                                     {has_depth, "depth/"},
                                     {has_intrinsics, "camera_intrinsic.json"}});
  match.matches = has_colour && has_depth &&
                  (has_intrinsics || has_log || fs::exists(path / kConfigName, ignored) ||
                   HasRedwoodNames(path, ColourFolder(path)));
  return match;
}

Result<OpenedLayout> OpenOpen3d(const LayoutSource& source) {
  const fs::path& folder = source.path;
  OpenedLayout opened;
  const std::string colour_folder = ColourFolder(folder);
  if (colour_folder.empty())
    return InvalidInput(fmt::format("{}: holds none of color/, image/, rgb/", folder.string()));
  Result<FolderPairs> read = PairFolders(folder, colour_folder, "depth", opened.warnings);
  if (!read) return read.error();

  const Result<std::optional<std::string>> config_text =
      dataset::ReadOptional(folder / kConfigName);
  if (!config_text) return config_text.error();
  const Result<Config> config = ParseConfig(*config_text, folder / kConfigName, opened.warnings);
  if (!config) return config.error();
  const Result<CameraOfFolder> of_folder =
      ReadCamera(source, *config, read->pairs, opened.warnings);
  if (!of_folder) return of_folder.error();
  const Result<double> scale = DepthScale(folder, *config, of_folder->intrinsics, opened.warnings);
  if (!scale) return scale.error();
  const PinholeCamera& camera = of_folder->intrinsics.camera;
  const Result<SettledImages> settled =
      SettleImages(source, {camera, camera, Pose3(), *scale}, read->pairs, opened.warnings);
  if (!settled) return settled.error();

  formats::FramePoses poses(read->pairs.size());
  std::optional<std::string> log_text;
  const Result<std::optional<fs::path>> log = FindTrajectory(folder, opened.warnings);
  if (!log) return log.error();
  if (*log) {
    opened.poses_file = (*log)->string();
    Result<std::string> text = dataset::ReadTextFile(**log);
    if (!text) return text.error();
    const auto parsed = ParseTrajectory(*text, **log, read->position.size(), opened.warnings);
    if (!parsed) return parsed.error();
    for (std::size_t i = 0; i < poses.size(); ++i)
      poses[i] = (*parsed)[read->position.at(read->pairs[i].colour.file)];
    log_text = *std::move(text);
  }
  Result<std::string> hash =
      dataset::HashFiles("open3d",
                         std::vector<dataset::NamedText>{{kSettingsName, source.settings_text},
                                                         {"intrinsics", of_folder->text},
                                                         {kConfigName, *config_text},
                                                         {"trajectory", log_text}},
                         folder,
                         read->pairs);
  if (!hash) return hash.error();
  opened.content_hash = *std::move(hash);
  opened.optics = WithStated(source.settings, dataset::Optics());
  opened.has_times = read->has_times;
  if (!opened.has_times) opened.warnings.push_back(NoTimesWarning(folder));
  opened.frames = dataset::MakeFileFrames(
      folder, settled->cameras, std::move(read->pairs), poses, settled->form);
  return opened;
}

}  // namespace deepslam::layouts
