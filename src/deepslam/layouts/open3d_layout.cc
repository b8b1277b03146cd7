// Folders of Open3D's reconstruction system and of the Redwood data sets: colour in color/, image/
// or rgb/, depth in depth/ (raw 1000 per metre unless config.json says `depth_scale`), intrinsics
// as JSON with the matrix column by column, trajectory.log with world from camera.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "deepslam/dataset/file_frames.h"
#include "deepslam/dataset/read_bytes.h"
#include "deepslam/layouts/layout.h"
#include "deepslam/layouts/pose_matrix.h"
#include "deepslam/layouts/text_lines.h"
#include "deepslam/layouts/tum_lists.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kUnitsPerM = 1000;
constexpr double kMaxTimeDifferenceS = 0.02;
// PrimeSense's, which Open3D takes when nothing is stated.
constexpr PinholeCamera kDefaultCamera{640, 480, 525, 525, 319.5, 239.5};
constexpr std::array kColourFolders = {"color", "image", "rgb"};
constexpr std::array kIntrinsicNames = {"camera_intrinsic.json", "intrinsic.json"};
constexpr std::string_view kConfigName = "config.json";

bool IsImage(const std::string& name) {
  std::string end = fs::path(name).extension().string();
  std::transform(end.begin(), end.end(), end.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return end == ".png" || end == ".jpg" || end == ".jpeg";
}

// An image's name: "frame000012", or Redwood's "0000012-000000400000" with microseconds.
struct ImageName {
  std::string file;
  std::optional<std::int64_t> number;
  std::optional<std::int64_t> time_us;
};

std::optional<std::int64_t> WholeNumber(std::string_view text) {
  if (text.empty() || text.size() > 18 ||
      text.find_first_not_of("0123456789") != std::string_view::npos) {
    return std::nullopt;
  }
  std::int64_t number = 0;
  for (const char c : text) number = 10 * number + (c - '0');
  return number;
}

ImageName ParseName(const std::string& folder, const std::string& name) {
  ImageName parsed{folder + "/" + name, std::nullopt, std::nullopt};
  const std::string stem = fs::path(name).stem().string();
  if (const std::size_t dash = stem.rfind('-'); dash != std::string::npos) {
    parsed.number = WholeNumber(std::string_view(stem).substr(0, dash));
    if (parsed.number) parsed.time_us = WholeNumber(std::string_view(stem).substr(dash + 1));
    if (parsed.time_us) return parsed;
  }
  const std::size_t last_other = stem.find_last_not_of("0123456789");
  parsed.number = WholeNumber(
      std::string_view(stem).substr(last_other == std::string::npos ? 0 : last_other + 1));
  return parsed;
}

std::vector<ImageName> ListImages(const fs::path& capture, const std::string& folder) {
  std::vector<ImageName> images;
  for (const std::string& name : dataset::ListFiles(capture / folder)) {
    if (IsImage(name)) images.push_back(ParseName(folder, name));
  }
  const bool numbered = std::all_of(
      images.begin(), images.end(), [](const ImageName& image) { return image.number; });
  if (numbered) {
    std::stable_sort(images.begin(), images.end(), [](const ImageName& a, const ImageName& b) {
      return a.number < b.number;
    });
  }
  return images;
}

dataset::TimedFile ToTimed(const ImageName& image, std::size_t position) {
  const double time_s =
      image.time_us ? static_cast<double>(*image.time_us) / 1e6
                    : TimeOfNumber(image.number.value_or(static_cast<std::int64_t>(position)));
  return {time_s, image.file, 0};
}

struct Pairs {
  std::vector<dataset::ImagePair> pairs;
  std::map<std::string, std::size_t> position;  // of a colour file among all: what poses refer to
  bool has_times = false;
};

// Images of one number. Empty when the numbers do not name frames: two files of one number, or
// moments that are too far apart.
std::vector<dataset::ImagePair> PairsByNumber(const std::vector<ImageName>& colour,
                                              const std::vector<ImageName>& depth) {
  std::map<std::int64_t, std::size_t> depth_of;
  for (std::size_t i = 0; i < depth.size(); ++i) {
    if (!depth[i].number || !depth_of.emplace(*depth[i].number, i).second) return {};
  }
  std::vector<dataset::ImagePair> pairs;
  for (std::size_t i = 0; i < colour.size(); ++i) {
    if (!colour[i].number || (i > 0 && colour[i].number == colour[i - 1].number)) return {};
    const auto found = depth_of.find(*colour[i].number);
    if (found == depth_of.end()) continue;
    pairs.push_back({ToTimed(colour[i], i), ToTimed(depth[found->second], found->second)});
    if (std::abs(pairs.back().colour.time_s - pairs.back().depth.time_s) > kMaxTimeDifferenceS)
      return {};
  }
  return pairs;
}

Result<Pairs> ReadPairs(const fs::path& folder,
                        const std::string& colour_folder,
                        std::vector<std::string>& warnings) {
  const std::vector<ImageName> colour = ListImages(folder, colour_folder);
  const std::vector<ImageName> depth = ListImages(folder, "depth");
  for (const auto& [images, name] : {std::pair(&colour, colour_folder), {&depth, "depth"}}) {
    if (images->empty()) {
      return InvalidInput(
          fmt::format("{}: holds no PNG or JPEG images; is the capture unpacked completely?",
                      (folder / name).string()));
    }
  }
  Pairs read;
  for (std::size_t i = 0; i < colour.size(); ++i) read.position.emplace(colour[i].file, i);
  read.has_times =
      std::all_of(depth.begin(), depth.end(), [](const ImageName& image) { return image.time_us; });
  read.pairs = PairsByNumber(colour, depth);
  if (read.pairs.empty() && read.has_times) {
    std::vector<dataset::TimedFile> timed_colour;
    std::vector<dataset::TimedFile> timed_depth;
    for (std::size_t i = 0; i < colour.size(); ++i) timed_colour.push_back(ToTimed(colour[i], i));
    for (std::size_t i = 0; i < depth.size(); ++i) timed_depth.push_back(ToTimed(depth[i], i));
    for (std::vector<dataset::TimedFile>* files : {&timed_colour, &timed_depth}) {
      std::stable_sort(files->begin(),
                       files->end(),
                       [](const dataset::TimedFile& a, const dataset::TimedFile& b) {
                         return a.time_s < b.time_s;
                       });
    }
    read.pairs = AssociateByTime(timed_colour, timed_depth, kMaxTimeDifferenceS);
  }
  if (read.pairs.empty() && colour.size() == depth.size()) {
    for (std::size_t i = 0; i < colour.size(); ++i) {
      const double time_s = TimeOfNumber(static_cast<std::int64_t>(i));
      read.pairs.push_back({{time_s, colour[i].file, 0}, {time_s, depth[i].file, 0}});
    }
  }
  if (read.pairs.empty()) {
    return InvalidInput(fmt::format(
        "{}: {} colour and {} depth images of which none belong together; give the two of a frame "
        "one number",
        folder.string(),
        colour.size(),
        depth.size()));
  }
  if (read.pairs.size() < std::max(colour.size(), depth.size())) {
    warnings.push_back(fmt::format("{}: {} colour and {} depth images make {} frames",
                                   folder.string(),
                                   colour.size(),
                                   depth.size(),
                                   read.pairs.size()));
  }
  return read;
}

Error JsonError(const fs::path& file, std::string_view fault) {
  return InvalidInput(fmt::format(
      "{}: {}; a complete file reads {{\"width\": 640, \"height\": 480, \"intrinsic_matrix\": [fx, "
      "0, 0, 0, fy, 0, cx, cy, 1]}} (column by column)",
      file.string(),
      fault));
}

Result<PinholeCamera> ParseIntrinsics(const std::string& text,
                                      const fs::path& file,
                                      std::vector<std::string>& warnings) {
  const json root = json::parse(text, nullptr, false);
  if (!root.is_object()) return JsonError(file, "is not a JSON object");
  PinholeCamera camera;
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
  return camera;
}

struct Config {
  std::optional<std::string> intrinsics;  // file
  double depth_scale = kUnitsPerM;
};

Result<Config> ParseConfig(const std::optional<std::string>& text, const fs::path& file) {
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
  if (const auto field = root.find("depth_scale"); field != root.end()) {
    const double scale = field->is_number() ? field->get<double>() : 0;
    if (!(scale >= 1 && scale <= 1e6)) {
      return InvalidInput(
          fmt::format("{}: field 'depth_scale' is {}, not a number in 1 .. 1000000 (usual: 1000); "
                      "it is the raw "
                      "depth of one metre",
                      file.string(),
                      field->dump()));
    }
    config.depth_scale = scale;
  }
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

// Blocks of five lines: `i j n`, then world from camera, row by row. i is the frame's index.
Result<std::vector<std::optional<Pose3>>> ParseTrajectory(const std::string& text,
                                                          const fs::path& file,
                                                          std::size_t num_frames,
                                                          std::vector<std::string>& warnings) {
  std::vector<std::optional<Pose3>> poses(num_frames);
  const std::vector<TextLine> lines = SplitLines(text);
  std::size_t num_unusable = 0;
  for (std::size_t begin = 0; begin < lines.size(); begin += 5) {
    const TextLine& head = lines[begin];
    const std::optional<std::int64_t> index =
        head.fields.size() == 3 ? WholeNumber(head.fields[0]) : std::nullopt;
    if (!index) {
      return LineError(
          file, head.number, "expected the line 'i j n' of a pose (three whole numbers)");
    }
    if (*index >= static_cast<std::int64_t>(num_frames)) {
      return LineError(
          file,
          head.number,
          fmt::format(
              "is the pose of frame {}, the capture has {} colour images", *index, num_frames));
    }
    std::array<double, 16> matrix{};
    for (std::size_t row = 0; row < 4; ++row) {
      if (begin + 1 + row >= lines.size())
        return LineError(file, head.number, "the file ends within this pose (truncated?)");
      const TextLine& line = lines[begin + 1 + row];
      const Status count = CheckFieldCount(file, line, 4, "a row of a 4 x 4 matrix");
      if (!count) return count.error();
      for (std::size_t column = 0; column < 4; ++column) {
        const std::optional<double> number = ParseNumber(line.fields[column]);
        if (!number) {
          return LineError(
              file, line.number, fmt::format("'{}' is not a number", Shown(line.fields[column])));
        }
        matrix[4 * row + column] = *number;
      }
    }
    std::optional<Pose3>& pose = poses[static_cast<std::size_t>(*index)];
    pose = PoseOfMatrix(matrix);
    if (!pose) ++num_unusable;
  }
  if (num_unusable > 0) {
    warnings.push_back(fmt::format("{}: {} poses are not finite or no rotations and were left out",
                                   file.string(),
                                   num_unusable));
  }
  return poses;
}

std::string ColourFolder(const fs::path& path) {
  std::error_code ignored;
  for (const char* name : kColourFolders) {
    if (fs::is_directory(path / name, ignored)) return name;
  }
  return "";
}

}  // namespace

LayoutMatch MatchOpen3d(const fs::path& path) {
  LayoutMatch match;
  std::error_code ignored;
  const bool has_colour = !ColourFolder(path).empty();
  const bool has_depth = fs::is_directory(path / "depth", ignored);
  const bool has_intrinsics = FindIntrinsics(path, {}).has_value();
  const bool has_log = fs::exists(path / "trajectory.log", ignored);
  const bool has_settings = fs::exists(path / kSettingsName, ignored);
  for (const auto& [found, piece] : {std::pair(has_colour, "color/ (or image/, rgb/)"),
                                     {has_depth, "depth/"},
                                     {has_intrinsics, "camera_intrinsic.json"}}) {
    if (found) {
      ++match.num_found;
    } else {
      match.missing.emplace_back(piece);
    }
  }
  match.matches = has_colour && has_depth &&
                  (has_intrinsics || has_log || has_settings ||
                   fs::exists(path / kConfigName, ignored) || ColourFolder(path) != "rgb");
  return match;
}

Result<OpenedLayout> OpenOpen3d(const LayoutSource& source) {
  const fs::path& folder = source.path;
  OpenedLayout opened;
  const std::string colour_folder = ColourFolder(folder);
  if (colour_folder.empty())
    return InvalidInput(fmt::format("{}: holds none of color/, image/, rgb/", folder.string()));
  Result<Pairs> read = ReadPairs(folder, colour_folder, opened.warnings);
  if (!read) return read.error();

  const Result<std::optional<std::string>> config_text =
      dataset::ReadOptional(folder / kConfigName);
  if (!config_text) return config_text.error();
  const Result<Config> config = ParseConfig(*config_text, folder / kConfigName);
  if (!config) return config.error();
  PinholeCamera camera = kDefaultCamera;
  std::optional<std::string> intrinsics_text;
  if (const std::optional<fs::path> file = FindIntrinsics(folder, *config)) {
    Result<std::string> text = dataset::ReadFileBytes(*file);
    if (!text) return text.error();
    const Result<PinholeCamera> parsed = ParseIntrinsics(*text, *file, opened.warnings);
    if (!parsed) return parsed.error();
    camera = *parsed;
    intrinsics_text = *std::move(text);
  } else if (!source.settings.has_camera()) {
    const Result<dataset::ImageSize> size =
        dataset::ReadImageSize(folder / read->pairs.front().colour.file);
    if (size && (size->width != camera.width || size->height != camera.height)) {
      return JsonError(folder / kIntrinsicNames[0],
                       "is missing, so the camera's intrinsics are unknown");
    }
    opened.warnings.push_back(fmt::format(
        "{}: missing; taken for the PrimeSense camera that Open3D takes by default (640 "
        "x 480, 525 px)",
        (folder / kIntrinsicNames[0]).string()));
  }
  const dataset::CaptureCameras cameras =
      WithStated(source.settings, {camera, camera, Pose3(), config->depth_scale});

  std::vector<std::optional<Pose3>> poses(read->pairs.size());
  std::optional<std::string> log_text;
  const Result<std::optional<fs::path>> log = FindTrajectory(folder, opened.warnings);
  if (!log) return log.error();
  if (*log) {
    Result<std::string> text = dataset::ReadFileBytes(**log);
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
                                                         {"intrinsics", intrinsics_text},
                                                         {kConfigName, *config_text},
                                                         {"trajectory", log_text}},
                         folder,
                         read->pairs);
  if (!hash) return hash.error();
  opened.content_hash = *std::move(hash);
  opened.has_times = read->has_times;
  if (!opened.has_times) opened.warnings.push_back(NoTimesWarning(folder));
  opened.frames = dataset::MakeFileFrames(folder, cameras, std::move(read->pairs), poses);
  return opened;
}

}  // namespace deepslam::layouts
