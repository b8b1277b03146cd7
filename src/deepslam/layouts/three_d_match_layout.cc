// 3DMatch's RGB-D sequences (and the example of tsdf-fusion): frame files as 7-Scenes has them,
// depth in millimetres and registered to colour, and one camera matrix for both in
// camera-intrinsics.txt, in the sequence's folder or in the scene's above it. Poses are world from
// camera.
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/formats/pose_matrix.h"
#include "deepslam/layouts/frame_files.h"
#include "deepslam/layouts/matrix_camera.h"
#include "deepslam/layouts/open_files.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

constexpr double kUnitsPerM = 1000;  // millimetres, by the benchmark's page
constexpr std::string_view kMatrixName = "camera-intrinsics.txt";

std::optional<fs::path> FindMatrix(const fs::path& folder) {
  std::error_code code;
  const fs::path full = fs::weakly_canonical(folder, code);
  for (const fs::path& place : {folder, (code ? folder : full).parent_path()}) {
    if (fs::is_regular_file(place / kMatrixName, code)) return place / kMatrixName;
  }
  return std::nullopt;
}

}  // namespace

LayoutMatch MatchThreeDMatch(const fs::path& path) {
  LayoutMatch match = MatchFrameFiles(path);
  const bool has_matrix = FindMatrix(path).has_value();
  if (has_matrix) ++match.num_found;
  if (!has_matrix) match.missing.emplace_back(kMatrixName);
  match.matches = match.matches && has_matrix;
  return match;
}

Result<OpenedLayout> OpenThreeDMatch(const LayoutSource& source) {
  const fs::path& folder = source.path;
  std::vector<std::string> warnings;
  std::vector<dataset::ImagePair> pairs = FrameFilePairs(folder);
  if (const Status there = CheckFrameFiles(folder, pairs); !there) return there.error();
  dataset::CaptureCameras cameras{{}, {}, Pose3(), kUnitsPerM};
  std::string matrix_text;
  if (!source.settings.has_camera()) {
    const fs::path file = FindMatrix(folder).value_or(folder / kMatrixName);
    Result<MatrixCamera> camera = ReadMatrixCamera(file, folder, pairs);
    if (!camera) return camera.error();
    cameras.colour = cameras.depth = camera->camera;
    matrix_text = std::move(camera->text);
  }
  const Result<SettledImages> settled = SettleImages(source, cameras, pairs, warnings);
  if (!settled) return settled.error();
  Result<formats::MatrixFiles> poses =
      formats::ReadMatrixFiles(folder, FramePoseNames(pairs), warnings);
  if (!poses) return poses.error();
  FilesOfLayout files{"3dmatch",
                      {{"camera", matrix_text}, {"poses", poses->text}},
                      std::move(pairs),
                      std::move(poses->poses),
                      (folder / "frame-*.pose.txt").string(),
                      *settled,
                      {},
                      false};
  return OpenFiles(source, std::move(files), std::move(warnings));
}

}  // namespace deepslam::layouts
