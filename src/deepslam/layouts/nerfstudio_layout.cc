// nerfstudio's transforms.json: an image per frame (file_path), its depth (depth_file_path, 16 bits
// in millimetres or real numbers in metres) and transform_matrix, world from a camera with y up and
// z back. Intrinsics (fl_x fl_y cx cy w h) and the lens (k1 k2 p1 p2 k3, or k1 ... k4 of
// OPENCV_FISHEYE) stand once or with each frame. A pixel's centre is at (0.5, 0.5) there.
#include <algorithm>
#include <array>
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

constexpr std::string_view kName = "transforms.json";
// Millimetres, the format's default (depth_unit_scale_factor 0.001).
constexpr double kUnitsPerM = 1000;
// The format's first pixel reaches from 0 to 1, as OpenGL has it; its centre here is 0.
constexpr double kPixelCentre = 0.5;

// Of a frame, or of the whole file where the frame has none; nothing where neither has.
std::optional<double> NumberOf(const json& frame, const json& root, const char* name) {
  for (const json* object : {&frame, &root}) {
    const auto field = object->find(name);
    if (field != object->end() && field->is_number()) return field->get<double>();
  }
  return std::nullopt;
}

Result<PinholeCamera> ParseCamera(const json& frame, const json& root, const fs::path& file) {
  PinholeCamera camera;
  const std::optional<double> width = NumberOf(frame, root, "w");
  const std::optional<double> height = NumberOf(frame, root, "h");
  const std::optional<double> fx = NumberOf(frame, root, "fl_x");
  if (!width || !height || !fx || !(*width >= 1 && *width <= 16384) ||
      !(*height >= 1 && *height <= 16384)) {
    return InvalidInput(fmt::format(
        "{}: fields 'w', 'h' and 'fl_x' are missing or no size; intrinsics have to stand there in "
        "px (camera_angle_x alone is not read)",
        file.string()));
  }
  camera.width = static_cast<int>(*width);
  camera.height = static_cast<int>(*height);
  camera.fx = *fx;
  camera.fy = NumberOf(frame, root, "fl_y").value_or(*fx);
  camera.cx = NumberOf(frame, root, "cx").value_or(0.5 * *width) - kPixelCentre;
  camera.cy = NumberOf(frame, root, "cy").value_or(0.5 * *height) - kPixelCentre;
  const Status plausible = dataset::CheckCamera(camera, file);
  if (!plausible) return plausible.error();
  return camera;
}

bool IsFisheye(const json& frame, const json& root) {
  for (const json* object : {&frame, &root}) {
    const auto model = object->find("camera_model");
    if (model != object->end() && model->is_string())
      return model->get<std::string>().find("FISHEYE") != std::string::npos;
  }
  return false;
}

LensDistortion ParseLens(const json& frame, const json& root) {
  const bool fisheye = IsFisheye(frame, root);
  LensDistortion lens{fisheye ? LensModel::kFisheye : LensModel::kRadialTangential, {}};
  const std::array<const char*, 5> names =
      fisheye ? std::array<const char*, 5>{"k1", "k2", "k3", "k4", "k4"}
              : std::array<const char*, 5>{"k1", "k2", "p1", "p2", "k3"};
  for (std::size_t i = 0; i < (fisheye ? 4U : 5U); ++i)
    lens.coefficients[i] = NumberOf(frame, root, names[i]).value_or(0);
  return lens;
}

struct ParsedFrame {
  std::string colour;
  std::string depth;
  PinholeCamera camera;
  LensDistortion lens;
  std::optional<Pose3> world_from_camera;
};

// A path below the capture's folder; an error of one that leaves it.
Result<std::string> ParsePath(const json& frame, const char* name, const fs::path& file) {
  const auto field = frame.find(name);
  if (field == frame.end() || !field->is_string() || field->get<std::string>().empty())
    return InvalidInput(fmt::format("{}: a frame has no field '{}'", file.string(), name));
  const fs::path path = fs::path(field->get<std::string>()).lexically_normal();
  const bool leaves = path.is_absolute() || path.begin()->string() == ".." ||
                      path.string().find('\0') != std::string::npos;
  if (leaves) {
    return InvalidInput(fmt::format(
        "{}: field '{}' leaves the capture's folder: write a path below it", file.string(), name));
  }
  return path.generic_string();
}

std::optional<Pose3> ParsePose(const json& frame) {
  const auto rows = frame.find("transform_matrix");
  if (rows == frame.end() || !rows->is_array() || rows->size() < 3 || rows->size() > 4)
    return std::nullopt;
  std::array<double, 16> matrix{};
  matrix[15] = 1;
  for (std::size_t row = 0; row < rows->size(); ++row) {
    const json& numbers = (*rows)[row];
    if (!numbers.is_array() || numbers.size() != 4) return std::nullopt;
    for (std::size_t column = 0; column < 4; ++column) {
      if (!numbers[column].is_number()) return std::nullopt;
      matrix[4 * row + column] = numbers[column].get<double>();
    }
  }
  const std::optional<Pose3> pose = formats::PoseOfMatrix(matrix);
  if (!pose) return std::nullopt;
  return formats::OfOpenGlCamera(*pose);
}

Result<ParsedFrame> ParseFrame(const json& frame, const json& root, const fs::path& file) {
  Result<std::string> colour = ParsePath(frame, "file_path", file);
  if (!colour) return colour.error();
  Result<std::string> depth = ParsePath(frame, "depth_file_path", file);
  if (!depth) return depth.error();
  const Result<PinholeCamera> camera = ParseCamera(frame, root, file);
  if (!camera) return camera.error();
  return ParsedFrame{
      *std::move(colour), *std::move(depth), *camera, ParseLens(frame, root), ParsePose(frame)};
}

bool HasDepth(const json& frame) { return frame.is_object() && frame.contains("depth_file_path"); }

// The digits that a name ends with; 0 where there are none.
std::int64_t NumberInName(const std::string& file) {
  const std::string stem = fs::path(file).stem().string();
  const std::size_t last_other = stem.find_last_not_of("0123456789");
  return WholeNumber(
             std::string_view(stem).substr(last_other == std::string::npos ? 0 : last_other + 1))
      .value_or(0);
}

// In the order of the numbers in their names, which is that of the recording.
Result<std::vector<ParsedFrame>> ParseFrames(const json& root,
                                             const fs::path& file,
                                             std::vector<std::string>& warnings) {
  const auto list = root.find("frames");
  if (list == root.end() || !list->is_array() || list->empty())
    return InvalidInput(fmt::format("{}: field 'frames' is missing or empty", file.string()));
  std::vector<ParsedFrame> frames;
  for (const json& frame : *list) {
    if (!HasDepth(frame)) continue;
    Result<ParsedFrame> parsed = ParseFrame(frame, root, file);
    if (!parsed) return parsed.error();
    frames.push_back(*std::move(parsed));
  }
  if (frames.empty()) {
    return InvalidInput(fmt::format(
        "{}: no frame has a 'depth_file_path': captures without depth are not mapped here",
        file.string()));
  }
  if (frames.size() < list->size()) {
    warnings.push_back(fmt::format("{}: {} of {} frames have no 'depth_file_path' and are skipped",
                                   file.string(),
                                   list->size() - frames.size(),
                                   list->size()));
  }
  std::ranges::stable_sort(frames, {}, [](const ParsedFrame& frame) {
    return std::pair(NumberInName(frame.colour), frame.colour);
  });
  return frames;
}

// Millimetres, unless the file says otherwise.
double UnitsOf(const json& root) {
  const std::optional<double> metres = NumberOf(json::object(), root, "depth_unit_scale_factor");
  return metres && *metres > 0 && *metres <= 1 ? 1 / *metres : kUnitsPerM;
}

}  // namespace

LayoutMatch MatchNerfstudio(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_regular_file(path / kName, ignored)) return {false, 0, {std::string(kName)}};
  // One without depth belongs to a capture of another layout.
  const Result<std::string> text = dataset::ReadTextFile(path / kName);
  const bool has_depth = text && text->find("depth_file_path") != std::string::npos;
  LayoutMatch match{has_depth, 1, {}};
  if (!has_depth) match.missing.emplace_back("depth_file_path in transforms.json");
  return match;
}

Result<OpenedLayout> OpenNerfstudio(const LayoutSource& source) {
  const fs::path file = source.path / kName;
  std::vector<std::string> warnings;
  Result<std::string> text = dataset::ReadTextFile(file);
  if (!text) return text.error();
  const json root = json::parse(*text, nullptr, false);
  if (!root.is_object())
    return InvalidInput(fmt::format("{}: is not a JSON object (damaged?)", file.string()));
  const Result<std::vector<ParsedFrame>> frames = ParseFrames(root, file, warnings);
  if (!frames) return frames.error();
  FilesOfLayout files{"nerfstudio", {{"transforms", *text}}, {}, {}, file.string(), {}, {}, false};
  std::int64_t number = 0;
  for (const ParsedFrame& frame : *frames) {
    const double time_s = TimeOfNumber(number++);
    files.pairs.push_back({{time_s, frame.colour, 0}, {time_s, frame.depth, 0}});
    files.poses.push_back(frame.world_from_camera);
    files.optics.colour_cameras.push_back(frame.camera);
  }
  const PinholeCamera& camera = frames->front().camera;
  const Result<SettledImages> settled =
      SettleImages(source, {camera, camera, Pose3(), UnitsOf(root)}, files.pairs, warnings);
  if (!settled) return settled.error();
  files.settled = *settled;
  const LensDistortion& lens = frames->front().lens;
  files.optics.colour = files.optics.depth = lens;
  if (!std::ranges::all_of(*frames, [&](const ParsedFrame& own) { return own.lens == lens; })) {
    warnings.push_back(fmt::format(
        "{}: frames have several lenses (k1, k2, ...); the first one's is taken for all",
        file.string()));
  }
  return OpenFiles(source, std::move(files), std::move(warnings));
}

}  // namespace deepslam::layouts
