// SUN3D: image/ and depth/ with Redwood's names (number and microseconds, the two streams apart),
// intrinsics.txt with one camera matrix for both, extrinsics/*.txt with three rows of world from
// camera per colour image, the newest file last. The bits of depth's PNG files (mm) are turned by
// three, the lowest ones highest: all values of the raw files are multiples of eight then.
#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/dataset/image_files.h"
#include "deepslam/dataset/read_bytes.h"
#include "deepslam/formats/pose_matrix.h"
#include "deepslam/formats/text_lines.h"
#include "deepslam/layouts/image_folders.h"
#include "deepslam/layouts/matrix_camera.h"
#include "deepslam/layouts/open_files.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

constexpr double kUnitsPerM = 1000;  // millimetres, once the file's bits are turned back
constexpr std::string_view kMatrixName = "intrinsics.txt";
constexpr std::string_view kPosesFolder = "extrinsics";

// Copies of the data set hold depth both ways: told by the first image that can be read.
bool HasTurnedBits(const fs::path& folder, const std::vector<dataset::ImagePair>& pairs) {
  for (const dataset::ImagePair& pair : pairs) {
    const fs::path file = folder / pair.depth.file;
    const Result<dataset::DepthFileKind> kind = dataset::ReadDepthKind(file);
    if (!kind || kind->real) continue;
    const Result<RawDepthImage> depth = dataset::ReadDepthFile(file, kind->width, kind->height);
    if (!depth) continue;
    return std::all_of(
        depth->begin(), depth->end(), [](std::uint16_t raw) { return (raw & 7U) == 0; });
  }
  return false;
}

struct Poses {
  formats::FramePoses of_images;
  std::string file;
  std::string text;
};

Result<Poses> ReadPoses(const fs::path& folder,
                        std::size_t num_images,
                        std::vector<std::string>& warnings) {
  const std::vector<std::string> names = dataset::ListFiles(folder / kPosesFolder);
  Poses poses{formats::FramePoses(num_images), {}, {}};
  const auto last = std::ranges::max_element(
      names, {}, [](const std::string& name) { return std::pair(name.ends_with(".txt"), name); });
  if (last == names.end() || !last->ends_with(".txt")) return poses;
  const fs::path file = folder / kPosesFolder / *last;
  Result<std::string> text = dataset::ReadTextFile(file);
  if (!text) return text.error();
  const auto numbers = formats::ParseNumbers(
      *text, file, 12 * num_images, "three rows of a 3 x 4 matrix per colour image");
  if (!numbers) {
    warnings.push_back(numbers.error().message + "; the poses were left out");
    return poses;
  }
  for (std::size_t i = 0; i < num_images; ++i) {
    std::array<double, 16> matrix{};
    std::copy_n(numbers->begin() + static_cast<std::ptrdiff_t>(12 * i), 12, matrix.begin());
    matrix[15] = 1;
    poses.of_images[i] = formats::PoseOfMatrix(matrix);
  }
  poses.file = file.string();
  poses.text = *std::move(text);
  return poses;
}

}  // namespace

LayoutMatch MatchSun3d(const fs::path& path) {
  std::error_code ignored;
  return MatchOfPieces({{fs::is_directory(path / "image", ignored), "image/"},
                        {fs::is_directory(path / "depth", ignored), "depth/"},
                        {fs::is_regular_file(path / kMatrixName, ignored), "intrinsics.txt"},
                        {fs::is_directory(path / kPosesFolder, ignored), "extrinsics/"}});
}

Result<OpenedLayout> OpenSun3d(const LayoutSource& source) {
  const fs::path& folder = source.path;
  std::vector<std::string> warnings;
  Result<FolderPairs> read = PairFolders(folder, "image", "depth", warnings);
  if (!read) return read.error();
  dataset::CaptureCameras cameras{{}, {}, Pose3(), kUnitsPerM};
  std::string text;
  if (!source.settings.has_camera()) {
    Result<MatrixCamera> camera = ReadMatrixCamera(folder / kMatrixName, folder, read->pairs);
    if (!camera) return camera.error();
    cameras.colour = cameras.depth = camera->camera;
    text = std::move(camera->text);
  }
  Result<SettledImages> settled = SettleImages(source, cameras, read->pairs, warnings);
  if (!settled) return settled.error();
  settled->form.rotated_bits = HasTurnedBits(folder, read->pairs);
  Result<Poses> poses = ReadPoses(folder, read->position.size(), warnings);
  if (!poses) return poses.error();
  formats::FramePoses of_pairs;
  for (const dataset::ImagePair& pair : read->pairs)
    of_pairs.push_back(poses->of_images[read->position.at(pair.colour.file)]);
  FilesOfLayout files{"sun3d",
                      {{"camera", text}, {"poses", poses->text}},
                      std::move(read->pairs),
                      std::move(of_pairs),
                      std::move(poses->file),
                      *std::move(settled),
                      {},
                      read->has_times};
  return OpenFiles(source, std::move(files), std::move(warnings));
}

}  // namespace deepslam::layouts
