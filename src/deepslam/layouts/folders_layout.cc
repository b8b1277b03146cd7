// Two folders of images and hardly anything beside: color, colour, rgb, image or images, and depth
// (NYU-like exercises, scripts for RealSense and Kinect, exports of apps). capture.yaml, or a text
// of the camera matrix, says what the camera is.
#include <array>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/dataset/read_bytes.h"
#include "deepslam/formats/text_lines.h"
#include "deepslam/layouts/image_folders.h"
#include "deepslam/layouts/open_files.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

// Of cameras that say nothing else.
constexpr double kUsualUnitsPerM = 1000;
// 9 or 16 numbers, a matrix row by row, or fx fy cx cy.
constexpr std::array<std::string_view, 10> kCameraNames = {"intrinsics.txt",
                                                           "intrinsic.txt",
                                                           "camera_intrinsics.txt",
                                                           "camera-intrinsics.txt",
                                                           "camera_intrinsic.txt",
                                                           "K.txt",
                                                           "k.txt",
                                                           "calibration.txt",
                                                           "calib.txt",
                                                           "camera.txt"};
constexpr std::array<std::string_view, 7> kPoseNames = {"pose.txt",
                                                        "poses.txt",
                                                        "traj.txt",
                                                        "trajectory.txt",
                                                        "camera_poses.txt",
                                                        "gt.txt",
                                                        "GT_Pose.txt"};
constexpr std::array<std::string_view, 2> kPoseFolders = {"pose", "poses"};

std::string ColourFolder(const fs::path& path) {
  return FirstFolder(path, {"color", "colour", "rgb", "image", "images"});
}

template <typename Names>
std::optional<fs::path> FirstFile(const fs::path& folder, const Names& names) {
  std::error_code ignored;
  for (const std::string_view name : names) {
    if (fs::is_regular_file(folder / name, ignored)) return folder / name;
  }
  return std::nullopt;
}

struct TextCamera {
  PinholeCamera camera;
  std::string text;
};

Result<TextCamera> ReadTextCamera(const fs::path& file, const dataset::ImageSize& size) {
  Result<std::string> text = dataset::ReadTextFile(file);
  if (!text) return text.error();
  std::size_t count = 0;
  for (const formats::TextLine& line : formats::SplitLines(*text)) count += line.fields.size();
  const std::size_t expected = count == 4 || count == 16 ? count : 9;
  const auto m =
      formats::ParseNumbers(*text, file, expected, "a camera matrix row by row, or fx fy cx cy");
  if (!m) return m.error();
  const std::vector<double>& k = *m;
  PinholeCamera camera{size.width, size.height, k[0], k[1], k[2], k[3]};
  if (count == 16) camera = {size.width, size.height, k[0], k[5], k[2], k[6]};
  if (count == 9) camera = {size.width, size.height, k[0], k[4], k[2], k[5]};
  if (const Status plausible = dataset::CheckCamera(camera, file); !plausible)
    return plausible.error();
  return TextCamera{camera, *std::move(text)};
}

Error NoCamera(const fs::path& folder) {
  const std::string other = FileOfCamera(folder);
  return InvalidInput(fmt::format(
      "{}: missing, or without 'camera', so the lens is unknown{}; 'deepslam doctor {} "
      "--write-capture-yaml' writes it as far as can be told, with what to correct",
      (folder / kSettingsName).string(),
      other.empty() ? std::string()
                    : fmt::format(" ({} may tell, but is not read in this layout)", other),
      folder.string()));
}

struct Cameras {
  dataset::CaptureCameras cameras;
  std::vector<dataset::NamedText> texts;
};

Result<Cameras> ReadCameras(const LayoutSource& source,
                            const std::vector<dataset::ImagePair>& pairs,
                            std::vector<std::string>& warnings) {
  Cameras read;
  read.cameras.depth_units_per_m = kUsualUnitsPerM;
  if (!source.settings.has_camera()) {
    const std::optional<fs::path> file = FirstFile(source.path, kCameraNames);
    if (!file) return NoCamera(source.path);
    const Result<dataset::ImageSize> size = FirstColourSize(source.path, pairs);
    if (!size) return size.error();
    const Result<TextCamera> camera = ReadTextCamera(*file, *size);
    if (!camera) return camera.error();
    read.cameras.colour = read.cameras.depth = camera->camera;
    read.texts.emplace_back("camera", camera->text);
  }
  if (!(source.settings.depth_units_per_m > 0)) {
    const Result<dataset::DepthFileKind> kind = FirstDepthKind(source.path, pairs);
    if (kind && !kind->real) {
      warnings.push_back(
          fmt::format("{}: nothing says what depth of one metre is; taken for {} (millimetres); "
                      "state 'depth_units_per_m' in {}",
                      source.path.string(),
                      kUsualUnitsPerM,
                      kSettingsName));
    }
  }
  return read;
}

struct Poses {
  formats::FramePoses of_pairs;
  std::string file;
  std::string text;
};

// pose/N.txt, of the colour image N.
Result<Poses> ReadPoseFolder(const fs::path& folder,
                             const std::string& pose_folder,
                             const std::vector<dataset::ImagePair>& pairs,
                             std::vector<std::string>& warnings) {
  std::vector<std::string> names;
  for (const dataset::ImagePair& pair : pairs)
    names.push_back(
        fmt::format("{}/{}.txt", pose_folder, fs::path(pair.colour.file).stem().string()));
  Result<formats::MatrixFiles> files = formats::ReadMatrixFiles(folder, names, warnings);
  if (!files) return files.error();
  return Poses{std::move(files->poses), (folder / pose_folder).string(), std::move(files->text)};
}

// A line per colour image.
Result<Poses> ReadPoseLines(const fs::path& file,
                            const FolderPairs& read,
                            std::vector<std::string>& warnings) {
  Result<std::string> text = dataset::ReadTextFile(file);
  if (!text) return text.error();
  formats::LineReader lines(*text);
  const formats::TextLine* const first = lines.Next();
  const std::size_t num_fields = first == nullptr ? 0 : first->fields.size();
  if (num_fields != 7 && num_fields != 12 && num_fields != 16) {
    warnings.push_back(fmt::format(
        "{}: its lines are no poses that are read in this layout (x y z qx qy qz qw, or a matrix "
        "row by row); it was left out",
        file.string()));
    return Poses{formats::FramePoses(read.pairs.size()), {}, {}};
  }
  Result<formats::FramePoses> poses = formats::ParsePoseLines(
      *text,
      file,
      num_fields == 7 ? formats::PoseColumns::kXyzQuatXyzw : formats::PoseColumns::kMatrix,
      warnings);
  if (!poses) return poses.error();
  // A line that was left out may be of a frame whose images were not written yet.
  if (poses->size() == read.position.size() + 1 && !poses->back()) poses->pop_back();
  if (poses->size() != read.position.size()) {
    warnings.push_back(
        fmt::format("{}: has {} poses, there are {} colour images; which belong together is not "
                    "known, so none was taken",
                    file.string(),
                    poses->size(),
                    read.position.size()));
    return Poses{formats::FramePoses(read.pairs.size()), {}, {}};
  }
  Poses of_frames{{}, file.string(), *std::move(text)};
  for (const dataset::ImagePair& pair : read.pairs)
    of_frames.of_pairs.push_back((*poses)[read.position.at(pair.colour.file)]);
  return of_frames;
}

Result<Poses> ReadPoses(const fs::path& folder,
                        const FolderPairs& read,
                        std::vector<std::string>& warnings) {
  std::error_code ignored;
  for (const std::string_view name : kPoseFolders) {
    if (fs::is_directory(folder / name, ignored))
      return ReadPoseFolder(folder, std::string(name), read.pairs, warnings);
  }
  if (const std::optional<fs::path> file = FirstFile(folder, kPoseNames))
    return ReadPoseLines(*file, read, warnings);
  return Poses{formats::FramePoses(read.pairs.size()), {}, {}};
}

}  // namespace

LayoutMatch MatchFolders(const fs::path& path) {
  const std::string colour = ColourFolder(path);
  std::error_code ignored;
  const bool has_depth = fs::is_directory(path / "depth", ignored);
  LayoutMatch match{
      !colour.empty() && has_depth, (colour.empty() ? 0 : 1) + (has_depth ? 1 : 0), {}};
  if (colour.empty()) match.missing.emplace_back("color/ (or colour/, rgb/, image/, images/)");
  if (!has_depth) match.missing.emplace_back("depth/");
  return match;
}

Result<OpenedLayout> OpenFolders(const LayoutSource& source) {
  std::vector<std::string> warnings;
  const std::string colour = ColourFolder(source.path);
  if (colour.empty()) {
    return InvalidInput(fmt::format("{}: holds none of color/, colour/, rgb/, image/, images/",
                                    source.path.string()));
  }
  Result<FolderPairs> read = PairFolders(source.path, colour, "depth", warnings);
  if (!read) return read.error();
  Result<Cameras> cameras = ReadCameras(source, read->pairs, warnings);
  if (!cameras) return cameras.error();
  const Result<SettledImages> settled =
      SettleImages(source, cameras->cameras, read->pairs, warnings);
  if (!settled) return settled.error();
  Result<Poses> poses = ReadPoses(source.path, *read, warnings);
  if (!poses) return poses.error();
  std::vector<dataset::NamedText> texts = std::move(cameras->texts);
  texts.emplace_back("poses", poses->text);
  FilesOfLayout files{"folders",
                      std::move(texts),
                      std::move(read->pairs),
                      std::move(poses->of_pairs),
                      std::move(poses->file),
                      *settled,
                      {},
                      read->has_times};
  return OpenFiles(source, std::move(files), std::move(warnings));
}

}  // namespace deepslam::layouts
