#include "deepslam/dataset/capture_settings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

namespace deepslam::dataset {
namespace {

constexpr int kMaxSidePx = 16384;
constexpr double kMinFieldOfViewDeg = 1;
constexpr double kMaxFieldOfViewDeg = 170;
// One unit per metre up to one per micrometre.
constexpr double kMaxUnitsPerM = 1e6;

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

Result<PinholeCamera> ParseCamera(const YAML::Node& node,
                                  const std::filesystem::path& file,
                                  std::vector<std::string>& warnings) {
  if (!node.IsMap()) return FieldError(file, node, "camera", "is not a table of intrinsics");
  constexpr std::array<std::string_view, 6> known = {"width", "height", "fx", "fy", "cx", "cy"};
  WarnOfUnknown(file, node, known, warnings);
  PinholeCamera camera;
  for (auto [key, target] : {std::pair{"width", &camera.width}, {"height", &camera.height}}) {
    const Result<int> value = Number<int>(file, node, key, std::string("camera.") + key);
    if (!value) return value.error();
    *target = *value;
  }
  for (auto [key, target] :
       {std::pair{"fx", &camera.fx}, {"fy", &camera.fy}, {"cx", &camera.cx}, {"cy", &camera.cy}}) {
    const Result<double> value = Number<double>(file, node, key, std::string("camera.") + key);
    if (!value) return value.error();
    *target = *value;
  }
  const Status plausible = CheckCamera(camera, Place(file, node));
  if (!plausible) return plausible.error();
  return camera;
}

Result<CaptureSettings> ParseRoot(const YAML::Node& root, const std::filesystem::path& file) {
  CaptureSettings settings;
  if (!root.IsMap()) return FieldError(file, root, "camera", "is missing");
  constexpr std::array<std::string_view, 3> known = {"format", "camera", "depth_units_per_m"};
  WarnOfUnknown(file, root, known, settings.warnings);
  if (const YAML::Node format = root["format"]) {
    if (!format.IsScalar() || format.Scalar() != "tum") {
      const std::string value = format.IsScalar() ? format.Scalar() : "a structure";
      return FieldError(file,
                        format,
                        "format",
                        fmt::format("is '{}', which is not known here (known: tum)", value));
    }
  }
  const YAML::Node camera_node = root["camera"];
  if (!camera_node) return FieldError(file, root, "camera", "is missing");
  const Result<PinholeCamera> camera = ParseCamera(camera_node, file, settings.warnings);
  if (!camera) return camera.error();
  settings.camera = *camera;
  const Result<double> units = Number<double>(file, root, "depth_units_per_m", "depth_units_per_m");
  if (!units) return units.error();
  if (*units < 1 || *units > kMaxUnitsPerM) {
    return FieldError(
        file,
        root["depth_units_per_m"],
        "depth_units_per_m",
        fmt::format("is {}, outside 1 .. {} (usual: 1000, 5000)", *units, kMaxUnitsPerM));
  }
  settings.depth_units_per_m = *units;
  return settings;
}

}  // namespace

Status CheckCamera(const PinholeCamera& camera, const std::filesystem::path& file) {
  const auto fault = [&](std::string_view field, double value, std::string_view expected) {
    return InvalidInput(fmt::format(
        "{}: field 'camera.{}' is {}; expected {}: write the colour camera's intrinsics in px",
        file.string(),
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
      return 0.5 * axis.size_px / std::tan(0.5 * field_of_view_deg * std::numbers::pi / 180.0);
    };
    const double min_px = focal_px(kMaxFieldOfViewDeg);
    const double max_px = focal_px(kMinFieldOfViewDeg);
    if (!(axis.focal_px >= min_px && axis.focal_px <= max_px)) {
      return fault(axis.focal_name,
                   axis.focal_px,
                   fmt::format("{:.1f} .. {:.1f} for this {}", min_px, max_px, axis.size_name));
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

Result<CaptureSettings> SettingsFromName(const std::filesystem::path& folder) {
  const std::string name = folder.filename().string();
  const auto says = [&](std::string_view word) { return name.find(word) != std::string::npos; };
  CaptureSettings settings;
  settings.depth_units_per_m = 5000;
  if (says("freiburg1") || says("fr1")) {
    settings.camera = {640, 480, 517.3, 516.5, 318.6, 255.3};
  } else if (says("freiburg2") || says("fr2")) {
    settings.camera = {640, 480, 520.9, 521.0, 325.1, 249.7};
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
      fmt::format("{}: missing; intrinsics and depth units taken from the folder's name '{}' (TUM "
                  "RGB-D, lens distortion left out)",
                  (folder / "capture.yaml").string(),
                  name));
  return settings;
}

std::string FormatCaptureSettings(const CaptureSettings& settings) {
  const PinholeCamera& c = settings.camera;
  return fmt::format(
      "format: {}\ncamera: {{width: {}, height: {}, fx: {}, fy: {}, cx: {}, cy: "
      "{}}}\ndepth_units_per_m: {}\n",
      settings.format,
      c.width,
      c.height,
      c.fx,
      c.fy,
      c.cx,
      c.cy,
      settings.depth_units_per_m);
}

}  // namespace deepslam::dataset
