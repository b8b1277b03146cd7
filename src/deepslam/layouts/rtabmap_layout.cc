// What RTAB-Map exports: folders NAME_rgb/, NAME_depth/ and NAME_calib/ of rtabmap-export, or rgb/,
// depth/ and calib/; images and calibrations of one name (a node's number or its time),
// calibrations as OpenCV's YAML; poses, where they were asked for as those of the camera, in a list
// "time x y z qx qy qz qw [number]". Depth (mm) has colour's view. confidence/ of the app for
// phones is not used: its scale differs between versions.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "deepslam/dataset/read_bytes.h"
#include "deepslam/formats/text_lines.h"
#include "deepslam/formats/tum_lists.h"
#include "deepslam/layouts/image_folders.h"
#include "deepslam/layouts/open_files.h"
#include "deepslam/layouts/tum_layout.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

constexpr double kUnitsPerM = 1000;  // millimetres: RTAB-Map's 16-bit depth

// "scan_" of scan_rgb/, scan_depth/ and scan_calib/; empty for rgb/, depth/, calib/; nothing where
// they are not there.
std::optional<std::string> PrefixOf(const fs::path& folder) {
  std::error_code code;
  std::optional<std::string> prefix;
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end;
       entry.increment(code)) {
    const std::string name = entry->path().filename().string();
    constexpr std::string_view kEnd = "calib";
    if (!name.ends_with(kEnd) || name.starts_with('.')) continue;
    const std::string begin = name.substr(0, name.size() - kEnd.size());
    std::error_code ignored;
    const bool whole = fs::is_directory(entry->path(), ignored) &&
                       fs::is_directory(folder / (begin + "rgb"), ignored) &&
                       fs::is_directory(folder / (begin + "depth"), ignored);
    if (whole && (!prefix || begin < *prefix)) prefix = begin;
  }
  return prefix;
}

Result<std::vector<double>> Data(const YAML::Node& root,
                                 const std::string& name,
                                 std::size_t least,
                                 const fs::path& file) {
  const YAML::Node data = root[name] && root[name].IsMap() ? root[name]["data"] : YAML::Node();
  std::vector<double> numbers;
  for (const auto& entry : data&& data.IsSequence() ? data : YAML::Node(YAML::NodeType::Sequence)) {
    double number = 0;
    if (!YAML::convert<double>::decode(entry, number) || !std::isfinite(number)) break;
    numbers.push_back(number);
  }
  if (numbers.size() >= least) return numbers;
  return InvalidInput(fmt::format(
      "{}: field '{}.data' is missing or holds fewer than {} numbers", file.string(), name, least));
}

// RTAB-Map rectifies images before it keeps them where the calibration has a projection matrix:
// that is their camera then. `lens` is set where the images are as they were taken.
struct Calibration {
  PinholeCamera camera;
  std::optional<LensDistortion> lens;
};

Result<Calibration> ParseRoot(const YAML::Node& root, const fs::path& file) {
  Calibration calibration;
  PinholeCamera& camera = calibration.camera;
  for (const auto& [name, target] :
       {std::pair("image_width", &camera.width), {"image_height", &camera.height}}) {
    if (!root.IsMap() || !root[name] || !YAML::convert<int>::decode(root[name], *target))
      return InvalidInput(fmt::format("{}: field '{}' is missing", file.string(), name));
  }
  if (root["projection_matrix"]) {
    const auto p = Data(root, "projection_matrix", 12, file);
    if (!p) return p.error();
    camera.fx = (*p)[0];
    camera.cx = (*p)[2];
    camera.fy = (*p)[5];
    camera.cy = (*p)[6];
  } else {
    const auto k = Data(root, "camera_matrix", 9, file);
    if (!k) return k.error();
    camera.fx = (*k)[0];
    camera.cx = (*k)[2];
    camera.fy = (*k)[4];
    camera.cy = (*k)[5];
    if (const auto d = Data(root, "distortion_coefficients", 4, file)) {
      const YAML::Node model = root["distortion_model"];
      const bool fisheye = model && model.IsScalar() && model.Scalar() == "equidistant";
      calibration.lens = LensDistortion{fisheye          ? LensModel::kFisheye
                                        : d->size() >= 8 ? LensModel::kRational
                                                         : LensModel::kRadialTangential,
                                        {}};
      const auto most =
          static_cast<std::size_t>(LensDistortion::NumCoefficients(calibration.lens->model));
      for (std::size_t i = 0; i < std::min(most, d->size()); ++i)
        calibration.lens->coefficients[i] = (*d)[i];
    }
  }
  const Status plausible = dataset::CheckCamera(camera, file);
  if (!plausible) return plausible.error();
  return calibration;
}

Result<Calibration> ParseCalibration(std::string text, const fs::path& file) {
  // OpenCV's first line "%YAML:1.0" is none of YAML's.
  if (text.starts_with('%')) text.erase(0, std::min(text.find('\n'), text.size()));
  try {
    return ParseRoot(YAML::Load(text), file);
  } catch (const YAML::Exception& fault) {
    return InvalidInput(fmt::format("{}: not valid YAML ({})", file.string(), fault.msg));
  }
}

struct Calibrations {
  std::vector<PinholeCamera> cameras;
  std::optional<LensDistortion> lens;  // of the first
  std::string text;
};

Result<Calibrations> ReadCalibrations(const fs::path& folder,
                                      const std::vector<dataset::ImagePair>& pairs) {
  Calibrations read;
  std::string last_text;
  for (const dataset::ImagePair& pair : pairs) {
    const fs::path file = folder / (fs::path(pair.colour.file).stem().string() + ".yaml");
    const Result<std::string> text = dataset::ReadTextFile(file);
    if (!text) return text.error();
    if (*text == last_text) {
      read.cameras.push_back(read.cameras.back());
      continue;
    }
    const Result<Calibration> calibration = ParseCalibration(*text, file);
    if (!calibration) return calibration.error();
    if (read.cameras.empty()) read.lens = calibration->lens;
    read.cameras.push_back(calibration->camera);
    read.text += *text;
    last_text = *text;
  }
  return read;
}

// The only list of poses of the camera; those of the robot's base are another's.
std::optional<fs::path> FindPoses(const fs::path& folder) {
  std::vector<std::string> names;
  for (const std::string& name : dataset::ListFiles(folder)) {
    if (name.ends_with("camera_poses.txt") || name == "poses.txt") names.push_back(name);
  }
  if (names.size() != 1) return std::nullopt;
  return folder / names.front();
}

// Images may be named by their times: "1560442322.123456.jpg".
bool SetTimes(std::vector<dataset::ImagePair>& pairs) {
  std::vector<double> times_s;
  for (const dataset::ImagePair& pair : pairs) {
    const std::string stem = fs::path(pair.colour.file).stem().string();
    const std::optional<double> time_s = formats::ParseNumber(stem);
    if (!time_s || stem.find('.') == std::string::npos || !(std::abs(*time_s) < 1e11)) return false;
    times_s.push_back(*time_s);
  }
  for (std::size_t i = 0; i < pairs.size(); ++i)
    pairs[i].colour.time_s = pairs[i].depth.time_s = times_s[i];
  return true;
}

// Images of one name, in the order of their numbers or times.
std::vector<dataset::ImagePair> PairsByName(const fs::path& folder,
                                            const std::string& colour_folder,
                                            const std::string& depth_folder) {
  std::map<std::string, std::string> depth;
  for (const std::string& name : dataset::ListFiles(folder / depth_folder)) {
    if (IsDepthName(name)) depth.emplace(fs::path(name).stem().string(), name);
  }
  std::vector<std::pair<double, dataset::ImagePair>> ordered;
  for (const std::string& name : dataset::ListFiles(folder / colour_folder)) {
    const std::string stem = fs::path(name).stem().string();
    const auto found = depth.find(stem);
    const std::optional<double> number = formats::ParseNumber(stem);
    if (!IsColourName(name) || found == depth.end() || !number || !std::isfinite(*number)) continue;
    ordered.push_back(
        {*number,
         {{0, colour_folder + "/" + name, 0}, {0, depth_folder + "/" + found->second, 0}}});
  }
  std::ranges::stable_sort(ordered, {}, [](const auto& entry) { return entry.first; });
  std::vector<dataset::ImagePair> pairs;
  for (auto& [number, pair] : ordered) {
    pair.colour.time_s = pair.depth.time_s = TimeOfNumber(static_cast<std::int64_t>(pairs.size()));
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

// By time where the images have some; else in order, where there are as many.
Result<formats::FramePoses> PosesOf(const std::string& text,
                                    const fs::path& file,
                                    const std::vector<dataset::ImagePair>& pairs,
                                    bool has_times,
                                    std::vector<std::string>& warnings) {
  const Result<std::vector<formats::TimedPose>> poses = formats::ParsePoses(text, file, warnings);
  if (!poses) return poses.error();
  if (has_times) return PosesAt(*poses, pairs);
  if (poses->size() == pairs.size()) {
    formats::FramePoses in_order;
    for (const formats::TimedPose& pose : *poses) in_order.emplace_back(pose.world_from_camera);
    return in_order;
  }
  warnings.push_back(
      fmt::format("{}: has {} poses, there are {} frames, and images named by numbers; which "
                  "belong together is "
                  "not known, so none was taken (export images named by their times)",
                  file.string(),
                  poses->size(),
                  pairs.size()));
  return formats::FramePoses(pairs.size());
}

}  // namespace

LayoutMatch MatchRtabMap(const fs::path& path) {
  if (PrefixOf(path)) return {true, 3, {}};
  return {false, 0, {"NAME_rgb/, NAME_depth/ and NAME_calib/"}};
}

Result<OpenedLayout> OpenRtabMap(const LayoutSource& source) {
  const fs::path& folder = source.path;
  std::vector<std::string> warnings;
  const std::string prefix = PrefixOf(folder).value_or("");
  FilesOfLayout files{
      "rtabmap", {}, PairsByName(folder, prefix + "rgb", prefix + "depth"), {}, {}, {}, {}, false};
  if (files.pairs.empty()) {
    return InvalidInput(fmt::format(
        "{}: {}rgb/ and {}depth/ hold no images of one number", folder.string(), prefix, prefix));
  }
  files.has_times = SetTimes(files.pairs);
  PinholeCamera camera;
  if (!source.settings.has_camera()) {
    Result<Calibrations> calibrations = ReadCalibrations(folder / (prefix + "calib"), files.pairs);
    if (!calibrations) return calibrations.error();
    camera = calibrations->cameras.front();
    files.optics = {calibrations->lens, calibrations->lens, std::move(calibrations->cameras), {}};
    files.texts.emplace_back("calibrations", calibrations->text);
  }
  const Result<SettledImages> settled = SettleImages(
      source, {camera, camera, Pose3(), kUnitsPerM}, files.pairs, warnings, CoarserDepth::kUsual);
  if (!settled) return settled.error();
  files.settled = *settled;
  if (const std::optional<fs::path> file = FindPoses(folder)) {
    const Result<std::string> text = dataset::ReadTextFile(*file);
    if (!text) return text.error();
    Result<formats::FramePoses> poses =
        PosesOf(*text, *file, files.pairs, files.has_times, warnings);
    if (!poses) return poses.error();
    files.poses = *std::move(poses);
    files.poses_file = file->string();
    files.texts.emplace_back("poses", *text);
  }
  return OpenFiles(source, std::move(files), std::move(warnings));
}

}  // namespace deepslam::layouts
