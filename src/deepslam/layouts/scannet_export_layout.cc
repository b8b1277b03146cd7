// ScanNet as its SensReader unpacks a .sens file: color/0.jpg, depth/0.png (mm), pose/0.txt (world
// from depth camera, -inf where lost), and 4 x 4 intrinsics and extrinsics of both cameras, in
// intrinsic/ or (ScanNet's frames at 25 frames' steps) beside the folders.
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "deepslam/dataset/read_bytes.h"
#include "deepslam/formats/pose_matrix.h"
#include "deepslam/formats/text_lines.h"
#include "deepslam/layouts/image_folders.h"
#include "deepslam/layouts/open_files.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

constexpr double kUnitsPerM = 1000;  // millimetres, 'depthShift' of the recordings
// A principal point farther from the middle, of the side, is one of images of another size.
constexpr double kFarFromMiddle = 0.2;

std::string ColourFolder(const fs::path& path) {
  return FirstFolder(path, {"color", "colour", "rgb"});
}

// intrinsic/intrinsic_color.txt and the like.
std::optional<fs::path> FindMatrix(const fs::path& folder,
                                   const std::string& kind,
                                   const std::string& camera) {
  std::error_code ignored;
  for (const char* place : {"intrinsic", "intrinsics", "."}) {
    for (const std::string& name : {kind + "_" + camera + ".txt", kind + "s_" + camera + ".txt"}) {
      const fs::path file = fs::path(place) == "." ? folder / name : folder / place / name;
      if (fs::is_regular_file(file, ignored)) return file;
    }
  }
  return std::nullopt;
}

struct Matrix {
  std::vector<double> numbers;  // 16, or 9 of intrinsics
  std::string text;
  fs::path file;
};

Result<std::optional<Matrix>> ReadMatrix(const fs::path& folder,
                                         const std::string& kind,
                                         const std::string& camera) {
  const std::optional<fs::path> file = FindMatrix(folder, kind, camera);
  if (!file) return std::optional<Matrix>();
  Result<std::string> text = dataset::ReadTextFile(*file);
  if (!text) return text.error();
  Result<std::vector<double>> numbers = formats::ParseNumbers(*text, *file, 16, "a 4 x 4 matrix");
  if (!numbers) return numbers.error();
  return std::optional(Matrix{*std::move(numbers), *std::move(text), *file});
}

PinholeCamera CameraOf(const Matrix& matrix, const dataset::ImageSize& size) {
  const std::vector<double>& k = matrix.numbers;
  return {size.width, size.height, k[0], k[5], k[2], k[6]};
}

bool IsOfItsSize(const PinholeCamera& camera) {
  return std::abs(camera.cx - 0.5 * camera.width) < kFarFromMiddle * camera.width &&
         std::abs(camera.cy - 0.5 * camera.height) < kFarFromMiddle * camera.height;
}

struct Cameras {
  dataset::CaptureCameras cameras;
  std::string text;
};

Result<Pose3> ReadExtrinsic(const fs::path& folder, const std::string& camera, std::string& text) {
  const Result<std::optional<Matrix>> matrix = ReadMatrix(folder, "extrinsic", camera);
  if (!matrix) return matrix.error();
  if (!*matrix) return Pose3();
  text += (*matrix)->text;
  const std::optional<Pose3> pose =
      formats::PoseOfMatrix(std::span<const double, 16>((*matrix)->numbers.data(), 16));
  if (!pose)
    return InvalidInput(
        fmt::format("{}: is no pose; correct or remove it", (*matrix)->file.string()));
  return *pose;
}

// Images of colour are often made as small as depth's and the intrinsics left: those of depth are
// nearly the same view's.
PinholeCamera FittingColour(const PinholeCamera& colour,
                            const PinholeCamera& depth,
                            const fs::path& file,
                            std::vector<std::string>& warnings) {
  if (IsOfItsSize(colour) || colour.width != depth.width || colour.height != depth.height)
    return colour;
  warnings.push_back(fmt::format(
      "{}: is of images of another size (cx {} of {} px); the depth camera's, of the same size, is "
      "taken for colour too",
      file.string(),
      colour.cx,
      colour.width));
  return depth;
}

Result<Cameras> ReadCameras(const fs::path& folder,
                            const std::vector<dataset::ImagePair>& pairs,
                            std::vector<std::string>& warnings) {
  Result<std::optional<Matrix>> colour = ReadMatrix(folder, "intrinsic", "color");
  if (!colour) return colour.error();
  Result<std::optional<Matrix>> depth = ReadMatrix(folder, "intrinsic", "depth");
  if (!depth) return depth.error();
  if (!*colour && !*depth) {
    return InvalidInput(
        fmt::format("{}: intrinsic/intrinsic_color.txt and intrinsic_depth.txt are "
                    "missing; state 'camera' in {}",
                    folder.string(),
                    kSettingsName));
  }
  const Result<dataset::ImageSize> colour_size = FirstColourSize(folder, pairs);
  if (!colour_size) return colour_size.error();
  const Result<dataset::DepthFileKind> kind = FirstDepthKind(folder, pairs);
  if (!kind) return kind.error();
  const Matrix& of_colour = *colour ? **colour : **depth;
  const Matrix& of_depth = *depth ? **depth : **colour;
  Cameras read;
  read.text = of_colour.text + of_depth.text;
  dataset::CaptureCameras& cameras = read.cameras;
  cameras.depth_units_per_m = kUnitsPerM;
  cameras.depth = CameraOf(of_depth, {kind->width, kind->height});
  cameras.colour =
      FittingColour(CameraOf(of_colour, *colour_size), cameras.depth, of_colour.file, warnings);
  for (const auto& [camera, matrix] :
       {std::pair(&cameras.colour, &of_colour), {&cameras.depth, &of_depth}}) {
    const Status plausible = dataset::CheckCamera(*camera, matrix->file);
    if (!plausible) return plausible.error();
  }
  const Result<Pose3> base_from_colour = ReadExtrinsic(folder, "color", read.text);
  if (!base_from_colour) return base_from_colour.error();
  const Result<Pose3> base_from_depth = ReadExtrinsic(folder, "depth", read.text);
  if (!base_from_depth) return base_from_depth.error();
  if (!(*base_from_colour == *base_from_depth))
    cameras.colour_from_depth = base_from_colour->Inverse() * *base_from_depth;
  return read;
}

}  // namespace

LayoutMatch MatchScanNetExport(const fs::path& path) {
  std::error_code ignored;
  const bool has_matrix =
      FindMatrix(path, "intrinsic", "depth") || FindMatrix(path, "intrinsic", "color");
  return MatchOfPieces({{!ColourFolder(path).empty(), "color/"},
                        {fs::is_directory(path / "depth", ignored), "depth/"},
                        {has_matrix, "intrinsic/intrinsic_depth.txt"}});
}

Result<OpenedLayout> OpenScanNetExport(const LayoutSource& source) {
  const fs::path& folder = source.path;
  std::vector<std::string> warnings;
  Result<FolderPairs> read = PairFolders(folder, ColourFolder(folder), "depth", warnings);
  if (!read) return read.error();
  Cameras cameras{{{}, {}, Pose3(), kUnitsPerM}, {}};
  if (!source.settings.has_camera()) {
    Result<Cameras> own = ReadCameras(folder, read->pairs, warnings);
    if (!own) return own.error();
    cameras = *std::move(own);
  }
  const Result<SettledImages> settled =
      SettleImages(source, cameras.cameras, read->pairs, warnings);
  if (!settled) return settled.error();
  std::vector<std::string> names;
  for (const dataset::ImagePair& pair : read->pairs)
    names.push_back(fmt::format("pose/{}.txt", fs::path(pair.colour.file).stem().string()));
  Result<formats::MatrixFiles> poses = formats::ReadMatrixFiles(folder, names, warnings);
  if (!poses) return poses.error();
  const Pose3& colour_from_depth = settled->cameras.colour_from_depth;
  if (!(colour_from_depth == Pose3())) {
    for (std::optional<Pose3>& pose : poses->poses) {
      if (pose) pose = *pose * colour_from_depth.Inverse();
    }
  }
  FilesOfLayout files{"scannet-export",
                      {{"cameras", cameras.text}, {"poses", poses->text}},
                      std::move(read->pairs),
                      std::move(poses->poses),
                      (folder / "pose").string(),
                      *settled,
                      {},
                      read->has_times};
  return OpenFiles(source, std::move(files), std::move(warnings));
}

}  // namespace deepslam::layouts
