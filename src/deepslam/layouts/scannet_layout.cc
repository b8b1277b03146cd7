// ScanNet's .sens: a whole capture in one file (sens_file.h).
#include <algorithm>
#include <cctype>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/every_nth.h"
#include "deepslam/dataset/file_frames.h"
#include "deepslam/formats/pose_matrix.h"
#include "deepslam/formats/sens_file.h"
#include "deepslam/layouts/layout.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

// Share of frames whose time is later than that of the one before, where times are times.
constexpr double kLeastAscending = 0.9;

std::optional<Pose3> ToPose(const std::array<float, 16>& matrix) {
  std::array<double, 16> numbers{};
  std::copy(matrix.begin(), matrix.end(), numbers.begin());
  return formats::PoseOfMatrix(numbers);
}

PinholeCamera ToCamera(const std::array<float, 16>& k, std::uint32_t width, std::uint32_t height) {
  // The shortest decimal of a 32-bit float is what was meant: 525.3, not 525.2999877929688.
  const auto meant = [](float value) { return std::stod(fmt::format("{}", value)); };
  return {static_cast<int>(width),
          static_cast<int>(height),
          meant(k[0]),
          meant(k[5]),
          meant(k[2]),
          meant(k[6])};
}

class SensFrames final : public dataset::StoredFrames {
 public:
  SensFrames(fs::path file,
             const dataset::CaptureCameras& cameras,
             std::vector<dataset::StoredFrame> frames,
             formats::SensIndex index)
      : dataset::StoredFrames(cameras, std::move(frames)),
        file_(std::move(file)),
        index_(std::move(index)) {}

  [[nodiscard]] Result<dataset::StoredColour> ReadColour(std::size_t i) const override {
    const formats::SensFrame& frame = index_.frames[i];
    Result<std::string> bytes = formats::ReadRange(file_, frame.colour_offset, frame.colour_bytes);
    if (!bytes) return bytes.error();
    dataset::StoredColour colour{
        dataset::ImageCodec::kOther, {}, {}, fmt::format("{}, frame {}", file_.string(), i)};
    if (index_.header.colour_codec != formats::SensColourCodec::kRaw) {
      colour.codec = dataset::CodecOf(*bytes);
      if (colour.codec == dataset::ImageCodec::kOther)
        return InvalidInput(colour.name + ": colour is neither a PNG nor a JPEG image");
      colour.bytes = *std::move(bytes);
      return colour;
    }
    const PinholeCamera& camera = cameras().colour;
    const std::size_t num_pixels =
        static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
    if (bytes->size() != 3 * num_pixels) {
      return InvalidInput(fmt::format("{}: raw colour has {} bytes, {} x {} px need {}",
                                      colour.name,
                                      bytes->size(),
                                      camera.width,
                                      camera.height,
                                      3 * num_pixels));
    }
    colour.pixels = ColourImage(camera.width, camera.height);
    auto byte = bytes->begin();
    for (Rgb8& pixel : colour.pixels) {
      pixel.r = static_cast<std::uint8_t>(*byte++);
      pixel.g = static_cast<std::uint8_t>(*byte++);
      pixel.b = static_cast<std::uint8_t>(*byte++);
    }
    return colour;
  }

  [[nodiscard]] Result<RawDepthImage> ReadDepth(std::size_t i) const override {
    const formats::SensFrame& frame = index_.frames[i];
    const Result<std::string> bytes =
        formats::ReadRange(file_, frame.depth_offset, frame.depth_bytes);
    if (!bytes) return bytes.error();
    Result<RawDepthImage> depth = formats::UnpackDepth(
        index_.header.depth_codec, *bytes, cameras().depth.width, cameras().depth.height);
    if (!depth)
      return InvalidInput(
          fmt::format("{}, frame {}: {}", file_.string(), i, depth.error().message));
    return depth;
  }

  [[nodiscard]] std::shared_ptr<const dataset::StoredFrames> Every(
      std::size_t step) const override {
    return std::make_shared<SensFrames>(
        file_,
        cameras(),
        EveryNth(frames(), step),
        formats::SensIndex{index_.header, EveryNth(index_.frames, step), index_.num_motions});
  }

 private:
  fs::path file_;
  formats::SensIndex index_;
};

bool IsSens(std::string name) {
  std::ranges::transform(
      name, name.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name.ends_with(".sens");
}

// The file itself, or the only .sens file of a folder; empty when there is none.
std::vector<fs::path> SensFiles(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_regular_file(path, ignored)) {
    if (IsSens(path.filename().string())) return {path};
    return {};
  }
  std::vector<fs::path> files;
  for (const std::string& name : dataset::ListFiles(path)) {
    if (IsSens(name)) files.push_back(path / name);
  }
  return files;
}

Result<dataset::CaptureCameras> CamerasOf(const formats::SensHeader& header, const fs::path& file) {
  dataset::CaptureCameras cameras;
  cameras.colour = ToCamera(header.colour_intrinsics, header.colour_width, header.colour_height);
  cameras.depth = ToCamera(header.depth_intrinsics, header.depth_width, header.depth_height);
  cameras.depth_units_per_m = static_cast<double>(header.depth_shift);
  const std::optional<Pose3> base_from_colour = ToPose(header.colour_extrinsics);
  const std::optional<Pose3> base_from_depth = ToPose(header.depth_extrinsics);
  if (!base_from_colour || !base_from_depth) {
    return InvalidInput(fmt::format("{}: field '{} extrinsics' is no pose",
                                    file.string(),
                                    base_from_colour ? "depth" : "colour"));
  }
  if (!(*base_from_colour == *base_from_depth))
    cameras.colour_from_depth = base_from_colour->Inverse() * *base_from_depth;
  return cameras;
}

Status CheckCameras(const dataset::CaptureCameras& cameras, const fs::path& file) {
  for (const auto& [camera, name] :
       {std::pair(&cameras.colour, "colour camera"), {&cameras.depth, "depth camera"}}) {
    const Status plausible = dataset::CheckCamera(*camera, file, name);
    if (!plausible) return plausible;
  }
  return Ok();
}

std::vector<dataset::StoredFrame> FramesOf(const formats::SensIndex& index,
                                           const dataset::CaptureCameras& cameras) {
  const Pose3 depth_from_colour = cameras.colour_from_depth.Inverse();
  const bool same_place = cameras.colour_from_depth == Pose3();
  std::vector<dataset::StoredFrame> frames;
  frames.reserve(index.frames.size());
  for (std::size_t i = 0; i < index.frames.size(); ++i) {
    const formats::SensFrame& stored = index.frames[i];
    dataset::StoredFrame frame{static_cast<double>(stored.colour_time_us) / 1e6,
                               static_cast<double>(stored.depth_time_us) / 1e6,
                               fmt::format("{:06d}", i),
                               ToPose(stored.world_from_depth)};
    if (frame.world_from_colour && !same_place)
      frame.world_from_colour = *frame.world_from_colour * depth_from_colour;
    frames.push_back(std::move(frame));
  }
  return frames;
}

// Some writers leave all times 0, others those of most frames, and some write what does not ascend:
// such numbers are no times. A few repeated ones are.
bool HasTimes(const std::vector<formats::SensFrame>& frames) {
  if (frames.size() == 1) return true;
  std::size_t num_ascending = 0;
  for (std::size_t i = 1; i < frames.size(); ++i)
    num_ascending += frames[i].depth_time_us > frames[i - 1].depth_time_us ? 1 : 0;
  return static_cast<double>(num_ascending) >=
         kLeastAscending * static_cast<double>(frames.size() - 1);
}

}  // namespace

LayoutMatch MatchScanNet(const fs::path& path) {
  const std::vector<fs::path> files = SensFiles(path);
  LayoutMatch match{files.size() == 1, files.empty() ? 0 : 1, {}};
  if (files.empty()) match.missing.emplace_back("a file NAME.sens");
  if (files.size() > 1)
    match.missing.push_back(
        fmt::format("one .sens file only (there are {}): name the one to read", files.size()));
  return match;
}

Result<OpenedLayout> OpenScanNet(const LayoutSource& source) {
  const std::vector<fs::path> files = SensFiles(source.path);
  if (files.size() != 1) {
    return InvalidInput(fmt::format(
        "{}: holds {} .sens files; name the one to read", source.path.string(), files.size()));
  }
  const fs::path& file = files.front();
  Result<formats::SensIndex> index = formats::ReadSensIndex(file);
  if (!index) return index.error();
  OpenedLayout opened;
  const std::uint64_t stated = index->header.num_frames;
  if (index->frames.size() < stated) {
    const std::string what =
        fmt::format("{}: says it holds {} frames, but ends (or has a wrong size) in frame {}",
                    file.string(),
                    stated,
                    index->frames.size());
    if (2 * index->frames.size() < stated)
      return InvalidInput(what + ": was it copied completely?");
    opened.warnings.push_back(what + "; the frames before it are used");
  }
  if (index->num_motions > 0) {
    opened.warnings.push_back(fmt::format(
        "{}: {} motion (IMU) measurements are not used", file.string(), index->num_motions));
  }
  const Result<dataset::CaptureCameras> own = CamerasOf(index->header, file);
  if (!own) return own.error();
  const dataset::CaptureCameras cameras = WithStated(source.settings, *own);
  if (const Status plausible = CheckCameras(cameras, file); !plausible) return plausible.error();
  const Result<std::string> digest = dataset::HashLargeFile(file);
  if (!digest) return digest.error();
  Result<std::string> hash = dataset::HashFiles(
      "scannet",
      std::vector<dataset::NamedText>{{kSettingsName, source.settings_text}, {"sens", *digest}},
      {},
      {});
  if (!hash) return hash.error();
  opened.content_hash = *std::move(hash);
  std::vector<dataset::StoredFrame> frames = FramesOf(*index, cameras);
  opened.optics = WithStated(source.settings, dataset::Optics());
  opened.poses_file = file.string();
  opened.has_times = HasTimes(index->frames);
  if (!opened.has_times) {
    for (std::size_t i = 0; i < frames.size(); ++i)
      frames[i].colour_time_s = frames[i].depth_time_s = TimeOfNumber(static_cast<std::int64_t>(i));
    opened.warnings.push_back(NoTimesWarning(file));
  }
  opened.frames = std::make_shared<SensFrames>(file, cameras, std::move(frames), *std::move(index));
  return opened;
}

}  // namespace deepslam::layouts
