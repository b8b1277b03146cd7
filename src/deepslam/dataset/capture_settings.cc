#include "deepslam/dataset/capture_settings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "deepslam/core/angles.h"

namespace deepslam::dataset {
namespace {

// No camera for rooms has larger images: files of more are refused.
constexpr int kMaxSidePx = 16384;
// A focal length of 57 widths: no lens for rooms is so long.
constexpr double kMinFieldOfViewDeg = 1;
constexpr double kMaxFieldOfViewDeg = 170;  // a pinhole's image of 180 deg is infinite
// One unit per metre up to one per micrometre.
constexpr double kMaxUnitsPerM = 1e6;
// Of a lens: those of a rational model reach some hundreds.
constexpr double kMaxCoefficient = 1e6;

constexpr std::string_view kExample =
    "format: tum\n"
    "camera: {width: 640, height: 480, fx: 525.0, fy: 525.0, cx: 319.5, cy: 239.5}\n"
    "depth_units_per_m: 5000";

std::string Place(const std::filesystem::path& file, const YAML::Node& node) {
  const YAML::Mark mark = node.Mark();
  return mark.is_null() ? file.string() : fmt::format("{}:{}", file.string(), mark.line + 1);
}

Error FieldError(const std::filesystem::path& file,
                 const YAML::Node& node,
                 std::string_view field,
                 std::string_view fault) {
  return InvalidInput(fmt::format(
      "{}: field '{}' {}; a complete file reads\n{}", Place(file, node), field, fault, kExample));
}

template <typename T>
Result<T> Number(const std::filesystem::path& file,
                 const YAML::Node& parent,
                 const std::string& key,
                 const std::string& field) {
  const YAML::Node node = parent[key];
  if (!node) return FieldError(file, parent, field, "is missing");
  if (!node.IsScalar()) return FieldError(file, node, field, "is not a number");
  T value{};
  if (!YAML::convert<T>::decode(node, value)) {
    const std::string_view what = std::is_integral_v<T> ? "a whole number" : "a number";
    return FieldError(file, node, field, fmt::format("is '{}', not {}", node.Scalar(), what));
  }
  if (!std::isfinite(static_cast<double>(value))) {
    return FieldError(
        file, node, field, fmt::format("is '{}', not a finite number", node.Scalar()));
  }
  return value;
}

void WarnOfUnknown(const std::filesystem::path& file,
                   const YAML::Node& map,
                   std::span<const std::string_view> known,
                   std::vector<std::string>& warnings) {
  for (const auto& entry : map) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "(not a name)";
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    warnings.push_back(fmt::format("{}: field '{}' is unknown and was ignored; known here: {}",
                                   Place(file, entry.first),
                                   key,
                                   fmt::join(known, ", ")));
  }
}

constexpr std::array<std::pair<std::string_view, LensModel>, 3> kLensModels = {
    {{"radial-tangential", LensModel::kRadialTangential},
     {"rational", LensModel::kRational},
     {"fisheye", LensModel::kFisheye}}};

// {model: radial-tangential, coefficients: [k1, k2, p1, p2, k3]}; of the last ones, those that are
// 0 may be left out.
Result<LensDistortion> ParseLens(const YAML::Node& node,
                                 const std::string& field,
                                 const std::filesystem::path& file,
                                 std::vector<std::string>& warnings) {
  if (!node.IsMap())
    return FieldError(file, node, field, "is not a table {model: ..., coefficients: [...]}");
  constexpr std::array<std::string_view, 2> known = {"model", "coefficients"};
  WarnOfUnknown(file, node, known, warnings);
  const YAML::Node model = node["model"];
  const std::string name = model && model.IsScalar() ? model.Scalar() : "";
  const auto found = std::ranges::find(
      kLensModels, name, [](const auto& known_model) { return known_model.first; });
  if (found == kLensModels.end()) {
    return FieldError(file,
                      node,
                      field + ".model",
                      fmt::format("is '{}', not radial-tangential, rational or fisheye", name));
  }
  LensDistortion lens{found->second, {}};
  const auto most = static_cast<std::size_t>(LensDistortion::NumCoefficients(lens.model));
  const YAML::Node numbers = node["coefficients"];
  const std::string fault = fmt::format("is not a list of 1 to {} numbers", most);
  if (!numbers || !numbers.IsSequence() || numbers.size() < 1 || numbers.size() > most)
    return FieldError(file, node, field + ".coefficients", fault);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    double& coefficient = lens.coefficients[i];
    if (!YAML::convert<double>::decode(numbers[i], coefficient) || !std::isfinite(coefficient) ||
        std::abs(coefficient) > kMaxCoefficient) {
      return FieldError(file, node, field + ".coefficients", fault);
    }
  }
  return lens;
}

struct CameraAndLens {
  PinholeCamera camera;
  std::optional<LensDistortion> lens;
};

Result<CameraAndLens> ParseCamera(const YAML::Node& node,
                                  const std::string& field,
                                  const std::filesystem::path& file,
                                  std::vector<std::string>& warnings) {
  if (!node.IsMap()) return FieldError(file, node, field, "is not a table of intrinsics");
  constexpr std::array<std::string_view, 7> known = {
      "width", "height", "fx", "fy", "cx", "cy", "distortion"};
  WarnOfUnknown(file, node, known, warnings);
  PinholeCamera camera;
  for (auto [key, target] : {std::pair{"width", &camera.width}, {"height", &camera.height}}) {
    const Result<int> value = Number<int>(file, node, key, field + "." + key);
    if (!value) return value.error();
    *target = *value;
  }
  for (auto [key, target] :
       {std::pair{"fx", &camera.fx}, {"fy", &camera.fy}, {"cx", &camera.cx}, {"cy", &camera.cy}}) {
    const Result<double> value = Number<double>(file, node, key, field + "." + key);
    if (!value) return value.error();
    *target = *value;
  }
  const Status plausible = CheckCamera(camera, Place(file, node), field);
  if (!plausible) return plausible.error();
  if (const YAML::Node distortion = node["distortion"]) {
    const Result<LensDistortion> lens =
        ParseLens(distortion, field + ".distortion", file, warnings);
    if (!lens) return lens.error();
    return CameraAndLens{camera, *lens};
  }
  return CameraAndLens{camera, std::nullopt};
}

Status ParseAssumed(const YAML::Node& node,
                    const std::filesystem::path& file,
                    CaptureSettings& settings) {
  for (const auto& entry : node.IsSequence() ? node : YAML::Node(YAML::NodeType::Sequence)) {
    if (entry.IsScalar()) settings.assumed.push_back(entry.Scalar());
  }
  if (node.IsSequence() && settings.assumed.size() == node.size()) return Ok();
  return FieldError(file, node, "assumed", "is not a list of fields");
}

template <std::size_t N>
Result<std::array<double, N>> Numbers(const std::filesystem::path& file,
                                      const YAML::Node& node,
                                      const std::string& field) {
  std::array<double, N> numbers{};
  if (!node || !node.IsSequence() || node.size() != N)
    return FieldError(file, node, field, fmt::format("is not a list of {} numbers", N));
  for (std::size_t i = 0; i < N; ++i) {
    if (!YAML::convert<double>::decode(node[i], numbers[i]) || !std::isfinite(numbers[i]))
      return FieldError(file, node, field, fmt::format("is not a list of {} numbers", N));
  }
  return numbers;
}

Result<Pose3> ParsePose(const YAML::Node& node,
                        const std::string& field,
                        const std::filesystem::path& file,
                        std::vector<std::string>& warnings) {
  if (!node.IsMap()) {
    return FieldError(
        file, node, field, "is not a table {translation_m: [x, y, z], rotation_xyzw: [...]}");
  }
  constexpr std::array<std::string_view, 2> known = {"translation_m", "rotation_xyzw"};
  WarnOfUnknown(file, node, known, warnings);
  const auto t = Numbers<3>(file, node["translation_m"], field + ".translation_m");
  if (!t) return t.error();
  const auto q = Numbers<4>(file, node["rotation_xyzw"], field + ".rotation_xyzw");
  if (!q) return q.error();
  const Eigen::Quaterniond rotation((*q)[3], (*q)[0], (*q)[1], (*q)[2]);
  if (std::abs(rotation.norm() - 1) > 0.01) {
    return FieldError(file,
                      node["rotation_xyzw"],
                      field + ".rotation_xyzw",
                      fmt::format("has length {}, a unit quaternion 1", rotation.norm()));
  }
  return Pose3{rotation.normalized(), {(*t)[0], (*t)[1], (*t)[2]}};
}

Status ParseFormat(const YAML::Node& node,
                   const std::filesystem::path& file,
                   CaptureSettings& settings) {
  const std::string value = node.IsScalar() ? node.Scalar() : "a structure";
  if (std::find(kFormats.begin(), kFormats.end(), value) == kFormats.end()) {
    return FieldError(
        file,
        node,
        "format",
        fmt::format(
            "is '{}', which is not known here (known: {})", value, fmt::join(kFormats, ", ")));
  }
  settings.format = value;
  return Ok();
}

Status ParseUnits(const YAML::Node& root,
                  const std::filesystem::path& file,
                  CaptureSettings& settings) {
  const Result<double> units = Number<double>(file, root, "depth_units_per_m", "depth_units_per_m");
  if (!units) return units.error();
  if (*units < 1 || *units > kMaxUnitsPerM) {
    return FieldError(
        file,
        root["depth_units_per_m"],
        "depth_units_per_m",
        fmt::format("is {}, outside 1 .. {} (usual: 1000, 5000){}",
                    *units,
                    kMaxUnitsPerM,
                    *units > 0 && *units < 1
                        ? fmt::format(": metres of one unit? Then write {:.6g}", 1 / *units)
                        : ""));
  }
  settings.depth_units_per_m = *units;
  return Ok();
}

Result<CaptureSettings> ParseRoot(const YAML::Node& root, const std::filesystem::path& file) {
  CaptureSettings settings;
  settings.format.clear();
  if (root.IsNull()) return settings;
  if (!root.IsMap()) return FieldError(file, root, "camera", "is missing");
  constexpr std::array<std::string_view, 8> known = {"format",
                                                     "camera",
                                                     "depth_units_per_m",
                                                     "depth_camera",
                                                     "colour_from_depth",
                                                     "min_confidence",
                                                     "max_frames",
                                                     "assumed"};
  WarnOfUnknown(file, root, known, settings.warnings);
  if (const YAML::Node format = root["format"]) {
    if (Status status = ParseFormat(format, file, settings); !status) return status.error();
  }
  if (const YAML::Node node = root["camera"]) {
    const Result<CameraAndLens> camera = ParseCamera(node, "camera", file, settings.warnings);
    if (!camera) return camera.error();
    settings.camera = camera->camera;
    settings.lens = camera->lens;
  }
  if (root["depth_units_per_m"]) {
    if (Status status = ParseUnits(root, file, settings); !status) return status.error();
  }
  if (const YAML::Node node = root["depth_camera"]) {
    const Result<CameraAndLens> camera = ParseCamera(node, "depth_camera", file, settings.warnings);
    if (!camera) return camera.error();
    settings.depth_camera = camera->camera;
    settings.depth_lens = camera->lens;
  }
  if (const YAML::Node node = root["colour_from_depth"]) {
    const Result<Pose3> pose = ParsePose(node, "colour_from_depth", file, settings.warnings);
    if (!pose) return pose.error();
    settings.colour_from_depth = *pose;
  }
  if (root["min_confidence"]) {
    const Result<int> least = Number<int>(file, root, "min_confidence", "min_confidence");
    if (!least) return least.error();
    settings.min_confidence = *least;
  }
  if (root["max_frames"]) {
    const Result<int> most = Number<int>(file, root, "max_frames", "max_frames");
    if (!most) return most.error();
    if (*most < 1) {
      return FieldError(
          file, root["max_frames"], "max_frames", fmt::format("is {}, not 1 or more", *most));
    }
    settings.max_frames = *most;
  }
  if (const YAML::Node assumed = root["assumed"]) {
    if (Status status = ParseAssumed(assumed, file, settings); !status) return status.error();
  }
  return settings;
}

}  // namespace

Status CheckCamera(const PinholeCamera& camera,
                   const std::filesystem::path& file,
                   std::string_view name) {
  const auto fault = [&](std::string_view field, double value, std::string_view expected) {
    return InvalidInput(
        fmt::format("{}: field '{}.{}' is {}; expected {}: write the camera's intrinsics in px",
                    file.string(),
                    name,
                    field,
                    value,
                    expected));
  };
  struct Axis {
    std::string_view size_name, focal_name, centre_name;
    int size_px;
    double focal_px, centre_px;
  };
  for (const Axis& axis : {Axis{"width", "fx", "cx", camera.width, camera.fx, camera.cx},
                           Axis{"height", "fy", "cy", camera.height, camera.fy, camera.cy}}) {
    if (axis.size_px < 1 || axis.size_px > kMaxSidePx) {
      return fault(axis.size_name, axis.size_px, fmt::format("1 .. {}", kMaxSidePx));
    }
    const auto focal_px = [&](double field_of_view_deg) {
      return 0.5 * axis.size_px / std::tan(0.5 * field_of_view_deg * kRadPerDeg);
    };
    const double min_px = focal_px(kMaxFieldOfViewDeg);
    const double max_px = focal_px(kMinFieldOfViewDeg);
    if (!(axis.focal_px >= min_px && axis.focal_px <= max_px)) {
      // ICL-NUIM's page prints a negative fy for images that are stored from the top down.
      return fault(axis.focal_name,
                   axis.focal_px,
                   fmt::format("{:.1f} .. {:.1f} for this {}{}",
                               min_px,
                               max_px,
                               axis.size_name,
                               axis.focal_px < 0 ? ", never negative" : ""));
    }
    if (!(axis.centre_px >= 0 && axis.centre_px <= axis.size_px - 1)) {
      return fault(axis.centre_name,
                   axis.centre_px,
                   fmt::format("a place inside the image, 0 .. {}", axis.size_px - 1));
    }
  }
  return Ok();
}

Result<CaptureSettings> ParseCaptureSettings(const std::string& text,
                                             const std::filesystem::path& file) {
  try {
    return ParseRoot(YAML::Load(text), file);
  } catch (const YAML::Exception& fault) {
    return InvalidInput(fmt::format("{}:{}: not valid YAML ({}); a complete file reads\n{}",
                                    file.string(),
                                    fault.mark.is_null() ? 1 : fault.mark.line + 1,
                                    fault.msg,
                                    kExample));
  }
}

Status RequireComplete(const CaptureSettings& settings, const std::filesystem::path& file) {
  const std::string_view missing = !settings.has_camera()              ? "camera"
                                   : settings.depth_units_per_m == 0.0 ? "depth_units_per_m"
                                                                       : "";
  if (missing.empty()) return Ok();
  return InvalidInput(fmt::format(
      "{}: field '{}' is missing; a complete file reads\n{}", file.string(), missing, kExample));
}

Result<CaptureSettings> SettingsFromName(const std::filesystem::path& folder) {
  const std::string name = folder.filename().string();
  const auto says = [&](std::string_view word) { return name.find(word) != std::string::npos; };
  CaptureSettings settings;
  settings.depth_units_per_m = 5000;
  if (says("freiburg1") || says("fr1")) {
    settings.camera = {640, 480, 517.3, 516.5, 318.6, 255.3};
    settings.lens =
        LensDistortion{LensModel::kRadialTangential, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}};
  } else if (says("freiburg2") || says("fr2")) {
    settings.camera = {640, 480, 520.9, 521.0, 325.1, 249.7};
    settings.lens =
        LensDistortion{LensModel::kRadialTangential, {0.2312, -0.7849, -0.0033, -0.0001, 0.9172}};
  } else if (says("freiburg3") || says("fr3")) {
    settings.camera = {640, 480, 535.4, 539.2, 320.1, 247.6};
  } else {
    return InvalidInput(
        fmt::format("{}: missing, so the camera's intrinsics are unknown; write this file with "
                    "your camera's values, as in\n{}",
                    (folder / "capture.yaml").string(),
                    kExample));
  }
  settings.warnings.push_back(
      fmt::format("{}: missing; intrinsics, lens and depth units taken from the folder's name '{}' "
                  "(TUM RGB-D)",
                  (folder / "capture.yaml").string(),
                  name));
  return settings;
}

namespace {

std::string FormatLens(const LensDistortion& lens) {
  const auto named = std::ranges::find(
      kLensModels, lens.model, [](const auto& known_model) { return known_model.second; });
  const auto count = static_cast<std::size_t>(LensDistortion::NumCoefficients(lens.model));
  return fmt::format(", distortion: {{model: {}, coefficients: [{}]}}",
                     named->first,
                     fmt::join(std::span(lens.coefficients).first(count), ", "));
}

std::string FormatCamera(const PinholeCamera& c, const std::optional<LensDistortion>& lens) {
  return fmt::format("{{width: {}, height: {}, fx: {}, fy: {}, cx: {}, cy: {}{}}}",
                     c.width,
                     c.height,
                     c.fx,
                     c.fy,
                     c.cx,
                     c.cy,
                     lens ? FormatLens(*lens) : "");
}

}  // namespace

std::string FormatCaptureSettings(const CaptureSettings& settings) {
  std::string text;
  if (!settings.format.empty()) text += fmt::format("format: {}\n", settings.format);
  if (settings.has_camera())
    text += fmt::format("camera: {}\n", FormatCamera(settings.camera, settings.lens));
  if (settings.depth_units_per_m > 0)
    text += fmt::format("depth_units_per_m: {}\n", settings.depth_units_per_m);
  if (settings.depth_camera)
    text += fmt::format("depth_camera: {}\n",
                        FormatCamera(*settings.depth_camera, settings.depth_lens));
  if (settings.colour_from_depth) {
    const Eigen::Vector3d& t = settings.colour_from_depth->translation_m;
    const Eigen::Quaterniond& q = settings.colour_from_depth->rotation;
    text += fmt::format(
        "colour_from_depth: {{translation_m: [{}, {}, {}], rotation_xyzw: [{}, {}, {}, {}]}}\n",
        t.x(),
        t.y(),
        t.z(),
        q.x(),
        q.y(),
        q.z(),
        q.w());
  }
  if (settings.min_confidence)
    text += fmt::format("min_confidence: {}\n", *settings.min_confidence);
  if (!settings.assumed.empty())
    text += fmt::format("assumed: [{}]\n", fmt::join(settings.assumed, ", "));
  if (settings.max_frames) text += fmt::format("max_frames: {}\n", *settings.max_frames);
  return text;
}

}  // namespace deepslam::dataset
