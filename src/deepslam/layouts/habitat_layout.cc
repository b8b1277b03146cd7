// What scripts around Habitat's simulator write: rgb/1.png, depth/1.png and GT_Pose.txt with a line
// "x y z qw qx qy qz" per frame, world (y up) from a camera that looks along -z. Its simulator's
// cameras see 90 degrees unless told otherwise, and such scripts store 10 m in 16 bits.
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/dataset/read_bytes.h"
#include "deepslam/layouts/image_folders.h"
#include "deepslam/layouts/open_files.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPosesName = "GT_Pose.txt";
constexpr double kUnitsPerM = 6553.5;  // 10 m in 16 bits

std::string ColourFolder(const fs::path& path) { return FirstFolder(path, {"rgb", "color"}); }

// 90 degrees wide, square pixels.
PinholeCamera UsualCamera(const dataset::ImageSize& size) {
  const double focal_px = 0.5 * size.width;
  return {
      size.width, size.height, focal_px, focal_px, 0.5 * (size.width - 1), 0.5 * (size.height - 1)};
}

}  // namespace

LayoutMatch MatchHabitat(const fs::path& path) {
  std::error_code ignored;
  return MatchOfPieces({{!ColourFolder(path).empty(), "rgb/"},
                        {fs::is_directory(path / "depth", ignored), "depth/"},
                        {fs::is_regular_file(path / kPosesName, ignored), "GT_Pose.txt"}});
}

Result<OpenedLayout> OpenHabitat(const LayoutSource& source) {
  const fs::path& folder = source.path;
  std::vector<std::string> warnings;
  Result<FolderPairs> read = PairFolders(folder, ColourFolder(folder), "depth", warnings);
  if (!read) return read.error();
  dataset::CaptureCameras cameras{{}, {}, Pose3(), kUnitsPerM};
  if (!source.settings.has_camera()) {
    const Result<dataset::ImageSize> size = FirstColourSize(folder, read->pairs);
    if (!size) return size.error();
    cameras.colour = cameras.depth = UsualCamera(*size);
    warnings.push_back(fmt::format(
        "{}: nothing says what the camera is; taken for Habitat's usual one (90 deg wide) and "
        "depth "
        "for {} a metre (10 m in 16 bits); state 'camera' and 'depth_units_per_m' in {} where it "
        "was another",
        folder.string(),
        kUnitsPerM,
        kSettingsName));
  }
  const Result<SettledImages> settled = SettleImages(source, cameras, read->pairs, warnings);
  if (!settled) return settled.error();
  const fs::path file = folder / kPosesName;
  Result<std::string> text = dataset::ReadTextFile(file);
  if (!text) return text.error();
  const Result<formats::FramePoses> all =
      formats::ParsePoseLines(*text, file, formats::PoseColumns::kXyzQuatWxyz, warnings);
  if (!all) return all.error();
  if (all->size() < read->position.size()) {
    warnings.push_back(fmt::format("{}: has {} poses, there are {} colour images",
                                   file.string(),
                                   all->size(),
                                   read->position.size()));
  }
  formats::FramePoses poses(read->pairs.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const std::size_t at = read->position.at(read->pairs[i].colour.file);
    if (at < all->size() && (*all)[at]) poses[i] = formats::OfOpenGlCamera(*(*all)[at]);
  }
  FilesOfLayout files{"habitat",
                      {{"poses", *text}},
                      std::move(read->pairs),
                      std::move(poses),
                      file.string(),
                      *settled,
                      {},
                      read->has_times};
  return OpenFiles(source, std::move(files), std::move(warnings));
}

}  // namespace deepslam::layouts
