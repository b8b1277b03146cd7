// Frame files as 7-Scenes has them, with a list "m_colorWidth = 960" of the recorder beside:
// info.txt (BundleFusion) or _info.txt (3RScan, whose depth is PGM). It has both cameras, what lies
// between them and depth's units. Poses are world from depth camera.
#include <array>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "deepslam/dataset/read_bytes.h"
#include "deepslam/formats/pose_matrix.h"
#include "deepslam/formats/text_lines.h"
#include "deepslam/layouts/frame_files.h"
#include "deepslam/layouts/open_files.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBundleFusionName = "info.txt";
constexpr std::string_view kThreeRScanName = "_info.txt";

// The numbers of each field that has some.
class Info {
 public:
  Info(std::string_view text, fs::path file) : file_(std::move(file)) {
    formats::LineReader lines(text);
    while (const formats::TextLine* const line = lines.Next()) {
      if (line->fields.size() < 3 || line->fields[1] != "=") continue;
      std::vector<double>& numbers = numbers_[std::string(line->fields[0])];
      for (std::size_t i = 2; i < line->fields.size(); ++i) {
        if (const std::optional<double> number = formats::ParseNumber(line->fields[i]))
          numbers.push_back(*number);
      }
    }
  }

  [[nodiscard]] const fs::path& file() const { return file_; }
  [[nodiscard]] bool Has(std::string_view name) const { return numbers_.contains(name); }
  [[nodiscard]] Result<std::span<const double>> Numbers(std::string_view name,
                                                        std::size_t count) const {
    const auto found = numbers_.find(name);
    if (found != numbers_.end() && found->second.size() == count)
      return std::span<const double>(found->second);
    return InvalidInput(
        fmt::format("{}: field '{}' has {} numbers, expected {} ('{} = ...'): is the file whole?",
                    file_.string(),
                    name,
                    found == numbers_.end() ? 0 : found->second.size(),
                    count,
                    name));
  }

 private:
  fs::path file_;
  std::map<std::string, std::vector<double>, std::less<>> numbers_;
};

Result<PinholeCamera> ReadCamera(const Info& info, const std::string& name) {
  const auto width = info.Numbers(fmt::format("m_{}Width", name), 1);
  if (!width) return width.error();
  const auto height = info.Numbers(fmt::format("m_{}Height", name), 1);
  if (!height) return height.error();
  const std::string capital = name == "color" ? "Color" : "Depth";
  const auto k = info.Numbers(fmt::format("m_calibration{}Intrinsic", capital), 16);
  if (!k) return k.error();
  for (const double side : {(*width)[0], (*height)[0]}) {
    if (!(side >= 1 && side <= 16384)) {
      return InvalidInput(fmt::format(
          "{}: field 'm_{}Width' or its height is {}", info.file().string(), name, side));
    }
  }
  const PinholeCamera camera{static_cast<int>((*width)[0]),
                             static_cast<int>((*height)[0]),
                             (*k)[0],
                             (*k)[5],
                             (*k)[2],
                             (*k)[6]};
  const Status plausible = dataset::CheckCamera(camera, info.file(), name);
  if (!plausible) return plausible.error();
  return camera;
}

Result<Pose3> ReadExtrinsic(const Info& info, const std::string& capital) {
  const std::string name = fmt::format("m_calibration{}Extrinsic", capital);
  if (!info.Has(name)) return Pose3();
  const auto matrix = info.Numbers(name, 16);
  if (!matrix) return matrix.error();
  const std::optional<Pose3> pose =
      formats::PoseOfMatrix(std::span<const double, 16>(matrix->data(), 16));
  if (pose) return *pose;
  return InvalidInput(fmt::format("{}: field '{}' is no pose", info.file().string(), name));
}

Result<dataset::CaptureCameras> ReadCameras(const Info& info) {
  dataset::CaptureCameras cameras;
  const Result<PinholeCamera> colour = ReadCamera(info, "color");
  if (!colour) return colour.error();
  const Result<PinholeCamera> depth = ReadCamera(info, "depth");
  if (!depth) return depth.error();
  const auto shift = info.Numbers("m_depthShift", 1);
  if (!shift) return shift.error();
  if (!((*shift)[0] >= 1 && (*shift)[0] <= 1e6)) {
    return InvalidInput(
        fmt::format("{}: field 'm_depthShift' is {}, outside 1 .. 1000000 (usual: "
                    "1000)",
                    info.file().string(),
                    (*shift)[0]));
  }
  cameras.colour = *colour;
  cameras.depth = *depth;
  cameras.depth_units_per_m = (*shift)[0];
  const Result<Pose3> base_from_colour = ReadExtrinsic(info, "Color");
  if (!base_from_colour) return base_from_colour.error();
  const Result<Pose3> base_from_depth = ReadExtrinsic(info, "Depth");
  if (!base_from_depth) return base_from_depth.error();
  if (!(*base_from_colour == *base_from_depth))
    cameras.colour_from_depth = base_from_colour->Inverse() * *base_from_depth;
  return cameras;
}

LayoutMatch MatchInfo(const fs::path& path, std::string_view name) {
  LayoutMatch match = MatchFrameFiles(path);
  std::error_code ignored;
  const bool has_info = fs::is_regular_file(path / name, ignored);
  if (has_info) ++match.num_found;
  if (!has_info) match.missing.emplace_back(name);
  match.matches = match.matches && has_info;
  return match;
}

Result<OpenedLayout> OpenInfo(const LayoutSource& source,
                              std::string_view tag,
                              std::string_view name) {
  const fs::path& folder = source.path;
  std::vector<std::string> warnings;
  std::vector<dataset::ImagePair> pairs = FrameFilePairs(folder);
  if (const Status there = CheckFrameFiles(folder, pairs); !there) return there.error();
  Result<std::string> text = dataset::ReadTextFile(folder / name);
  if (!text) return text.error();
  const Result<dataset::CaptureCameras> cameras = ReadCameras(Info(*text, folder / name));
  if (!cameras) return cameras.error();
  const Result<SettledImages> settled = SettleImages(source, *cameras, pairs, warnings);
  if (!settled) return settled.error();
  Result<formats::MatrixFiles> poses =
      formats::ReadMatrixFiles(folder, FramePoseNames(pairs), warnings);
  if (!poses) return poses.error();
  const Pose3& colour_from_depth = settled->cameras.colour_from_depth;
  if (!(colour_from_depth == Pose3())) {
    for (std::optional<Pose3>& pose : poses->poses) {
      if (pose) pose = *pose * colour_from_depth.Inverse();
    }
  }
  FilesOfLayout files{tag,
                      {{"info", *text}, {"poses", poses->text}},
                      std::move(pairs),
                      std::move(poses->poses),
                      (folder / "frame-*.pose.txt").string(),
                      *settled,
                      {},
                      false};
  return OpenFiles(source, std::move(files), std::move(warnings));
}

}  // namespace

LayoutMatch MatchBundleFusion(const fs::path& path) { return MatchInfo(path, kBundleFusionName); }
LayoutMatch MatchThreeRScan(const fs::path& path) { return MatchInfo(path, kThreeRScanName); }

Result<OpenedLayout> OpenBundleFusion(const LayoutSource& source) {
  return OpenInfo(source, "bundlefusion", kBundleFusionName);
}
Result<OpenedLayout> OpenThreeRScan(const LayoutSource& source) {
  return OpenInfo(source, "3rscan", kThreeRScanName);
}

}  // namespace deepslam::layouts
