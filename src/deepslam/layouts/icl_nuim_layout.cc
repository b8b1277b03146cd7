// ICL-NUIM, the archives of PNG files made to look like TUM RGB-D. What differs from TUM:
// associations.txt has depth first; times are frame numbers; there is no first pose; the
// trajectory (NAME.gt.freiburg) is in the renderer's world, whose y points up while the camera's
// fy is negative. The images lie the right way up, so that fy is positive here, and the trajectory
// is mirrored: S T S with S = diag(1, -1, 1, 1).
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/dataset/file_frames.h"
#include "deepslam/dataset/read_bytes.h"
#include "deepslam/formats/text_lines.h"
#include "deepslam/layouts/layout.h"
#include "deepslam/layouts/settle_images.h"
#include "deepslam/layouts/tum_layout.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

constexpr PinholeCamera kCamera{640, 480, 481.20, 480.00, 319.50, 239.50};
constexpr double kUnitsPerM = 5000;  // its files are made compatible with the TUM benchmark's
constexpr std::string_view kPosesEnd = ".gt.freiburg";

bool IsNumber(std::string_view field) {
  return !field.empty() && field.find_first_not_of("0123456789") == std::string_view::npos;
}

std::vector<std::string> PoseFiles(const fs::path& folder) {
  std::vector<std::string> files;
  for (std::string& name : dataset::ListFiles(folder)) {
    if (name.ends_with(kPosesEnd)) files.push_back(std::move(name));
  }
  return files;
}

// "0 depth/0.png 0 rgb/0.png"
bool HasNumberedAssociations(const fs::path& folder) {
  const Result<std::string> text = dataset::ReadTextFile(folder / "associations.txt");
  if (!text) return false;
  const std::vector<formats::TextLine> lines = formats::SplitLines(*text);
  if (lines.empty() || lines.front().fields.size() != 4) return false;
  const std::vector<std::string_view>& fields = lines.front().fields;
  return IsNumber(fields[0]) && IsNumber(fields[2]) && fields[1].starts_with("depth/") &&
         fields[3].starts_with("rgb/");
}

// Without associations.txt: the colour and depth images of one number.
Result<std::vector<dataset::ImagePair>> PairsByNumber(const fs::path& folder) {
  std::map<long, dataset::ImagePair> by_number;
  for (const std::string& name : dataset::ListFiles(folder / "rgb")) {
    const std::string stem = fs::path(name).stem().string();
    if (!IsNumber(stem) || stem.size() > 9) continue;
    const double number = std::stod(stem);
    by_number[std::stol(stem)] = {{number, "rgb/" + name, 0},
                                  {number, "depth/" + stem + ".png", 0}};
  }
  std::vector<dataset::ImagePair> pairs;
  pairs.reserve(by_number.size());
  for (auto& [number, pair] : by_number) pairs.push_back(std::move(pair));
  if (pairs.empty()) {
    return InvalidInput(
        fmt::format("{}: holds no images rgb/0.png, rgb/1.png ...; unpack the archive of PNG files "
                    "(TUM RGB-D compatible) completely",
                    folder.string()));
  }
  return pairs;
}

Pose3 Mirrored(const Pose3& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  const Eigen::Vector3d& t = pose.translation_m;
  return {Eigen::Quaterniond(q.w(), -q.x(), q.y(), -q.z()), {t.x(), -t.y(), t.z()}};
}

// By frame number.
Result<std::map<double, Pose3>> ReadPoses(const std::string& text,
                                          const fs::path& file,
                                          std::vector<std::string>& warnings) {
  const Result<std::vector<formats::TimedPose>> poses = formats::ParsePoses(text, file, warnings);
  if (!poses) return poses.error();
  std::map<double, Pose3> by_number;
  for (const formats::TimedPose& pose : *poses)
    by_number.emplace(pose.time_s, Mirrored(pose.world_from_camera));
  return by_number;
}

}  // namespace

LayoutMatch MatchIclNuim(const fs::path& path) {
  LayoutMatch match = MatchTum(path);
  std::error_code ignored;
  const bool has_images = fs::is_directory(path / "rgb", ignored);
  const bool has_poses = !PoseFiles(path).empty();
  if (has_poses) ++match.num_found;
  if (!has_poses) match.missing.emplace_back("NAME.gt.freiburg");
  // A user's capture.yaml says that it is a capture of another camera, unless it names this layout.
  match.matches =
      has_images &&
      (has_poses || (HasNumberedAssociations(path) && !fs::exists(path / kSettingsName, ignored)));
  return match;
}

Result<OpenedLayout> OpenIclNuim(const LayoutSource& source) {
  const fs::path& folder = source.path;
  OpenedLayout opened;
  std::error_code ignored;
  Result<std::vector<dataset::ImagePair>> pairs = fs::exists(folder / "associations.txt", ignored)
                                                      ? ReadPairs(folder, opened.warnings)
                                                      : PairsByNumber(folder);
  if (!pairs) return pairs.error();
  const Status files_exist = dataset::CheckFilesExist(folder, *pairs, opened.warnings);
  if (!files_exist) return files_exist.error();

  std::vector<std::string> pose_files = PoseFiles(folder);
  if (pose_files.empty() && fs::exists(folder / kPosesName, ignored))
    pose_files.emplace_back(kPosesName);
  if (pose_files.size() > 1) {
    return InvalidInput(
        fmt::format("{}: holds several trajectories ({}); leave the one of these images",
                    folder.string(),
                    fmt::join(pose_files, ", ")));
  }
  std::optional<std::string> poses_text;
  std::vector<std::optional<Pose3>> world_from_colour(pairs->size());
  if (!pose_files.empty()) {
    const fs::path file = folder / pose_files.front();
    Result<std::string> text = dataset::ReadTextFile(file);
    if (!text) return text.error();
    const auto poses = ReadPoses(*text, file, opened.warnings);
    if (!poses) return poses.error();
    for (std::size_t i = 0; i < pairs->size(); ++i) {
      const auto pose = poses->find((*pairs)[i].depth.time_s);
      if (pose != poses->end()) world_from_colour[i] = pose->second;
    }
    opened.poses_file = file.string();
    poses_text = *std::move(text);
  }
  for (dataset::ImagePair& pair : *pairs) {
    for (dataset::TimedFile* file : {&pair.colour, &pair.depth})
      file->time_s = TimeOfNumber(std::llround(file->time_s));
  }
  const Result<SettledImages> settled =
      SettleImages(source, {kCamera, kCamera, Pose3(), kUnitsPerM}, *pairs, opened.warnings);
  if (!settled) return settled.error();
  Result<std::string> hash = dataset::HashFiles(
      "icl-nuim",
      std::vector<dataset::NamedText>{{kSettingsName, source.settings_text}, {"poses", poses_text}},
      folder,
      *pairs);
  if (!hash) return hash.error();
  opened.content_hash = *std::move(hash);
  opened.frames = dataset::MakeFileFrames(
      folder, settled->cameras, *std::move(pairs), world_from_colour, settled->form);
  opened.optics = WithStated(source.settings, dataset::Optics());
  opened.has_times = false;
  return opened;
}

}  // namespace deepslam::layouts
