// ScanNet++'s folder of the iPhone: rgb/frame_000000.jpg or the video rgb.mkv (1920 x 1440),
// depth/frame_000000.png (256 x 192, mm, seen from colour's place; the data set's own script makes
// it of depth.bin), and pose_intrinsic_imu.json with "intrinsic", "timestamp" and "aligned_pose"
// (or "pose"), world from camera, for every "frame_000000".
#include <array>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "deepslam/dataset/read_bytes.h"
#include "deepslam/formats/pose_matrix.h"
#include "deepslam/layouts/image_folders.h"
#include "deepslam/layouts/open_files.h"
#include "deepslam/layouts/video_colour.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kUnitsPerM = 1000;  // millimetres, by the data set's documentation
constexpr std::string_view kName = "pose_intrinsic_imu.json";
constexpr std::array<std::string_view, 3> kVideos = {"rgb.mkv", "rgb.mp4", "rgb.mov"};
constexpr double kMaxTimeS = 1e11;  // s since 1970: 3,000 years; what is beyond is no time

struct ParsedFrame {
  double fx = 0, fy = 0, cx = 0, cy = 0;  // px of the colour image
  std::optional<Pose3> world_from_camera;
  std::optional<double> time_s;
};

// Rows of a matrix; nothing where it is none of that size.
template <std::size_t Rows, std::size_t Columns>
std::optional<std::array<double, Rows * Columns>> Matrix(const json& frame, const char* name) {
  const auto rows = frame.find(name);
  if (rows == frame.end() || !rows->is_array() || rows->size() != Rows) return std::nullopt;
  std::array<double, Rows * Columns> numbers{};
  for (std::size_t row = 0; row < Rows; ++row) {
    const json& of_row = (*rows)[row];
    if (!of_row.is_array() || of_row.size() != Columns) return std::nullopt;
    for (std::size_t column = 0; column < Columns; ++column) {
      if (!of_row[column].is_number()) return std::nullopt;
      numbers[Columns * row + column] = of_row[column].get<double>();
    }
  }
  return numbers;
}

Result<ParsedFrame> ParseFrame(const std::string& name, const json& frame, const fs::path& file) {
  const auto k = frame.is_object() ? Matrix<3, 3>(frame, "intrinsic") : std::nullopt;
  if (!k) {
    return InvalidInput(
        fmt::format("{}: field '{}.intrinsic' is missing or no 3 x 3 matrix", file.string(), name));
  }
  ParsedFrame parsed{(*k)[0], (*k)[4], (*k)[2], (*k)[5], std::nullopt, std::nullopt};
  for (const char* pose : {"aligned_pose", "pose"}) {
    const auto matrix = Matrix<4, 4>(frame, pose);
    if (!matrix) continue;
    parsed.world_from_camera = formats::PoseOfMatrix(*matrix);
    break;
  }
  const auto time = frame.find("timestamp");
  if (time != frame.end() && time->is_number() && std::abs(time->get<double>()) < kMaxTimeS)
    parsed.time_s = time->get<double>();
  return parsed;
}

// By the number in "frame_000012".
Result<std::map<std::int64_t, ParsedFrame>> ParseFrames(const std::string& text,
                                                        const fs::path& file) {
  const json root = json::parse(text, nullptr, false);
  if (!root.is_object())
    return InvalidInput(fmt::format("{}: is not a JSON object (damaged?)", file.string()));
  std::map<std::int64_t, ParsedFrame> frames;
  for (const auto& [name, frame] : root.items()) {
    constexpr std::string_view kPrefix = "frame_";
    if (!name.starts_with(kPrefix)) continue;
    const std::optional<std::int64_t> number =
        WholeNumber(std::string_view(name).substr(kPrefix.size()));
    if (!number) continue;
    const Result<ParsedFrame> parsed = ParseFrame(name, frame, file);
    if (!parsed) return parsed.error();
    frames.emplace(*number, *parsed);
  }
  if (frames.empty())
    return InvalidInput(fmt::format("{}: holds no 'frame_000000'", file.string()));
  return frames;
}

std::map<std::int64_t, std::string> ImagesOf(const fs::path& capture,
                                             const std::string& folder,
                                             bool (*is_image)(std::string_view)) {
  std::map<std::int64_t, std::string> files;
  for (const NumberedImage& image : ListImages(capture, folder, is_image)) {
    if (image.number) files.emplace(*image.number, image.file);
  }
  return files;
}

bool HasTimes(const std::map<std::int64_t, ParsedFrame>& frames) {
  std::optional<double> last;
  for (const auto& [number, frame] : frames) {
    if (!frame.time_s || (last && *frame.time_s <= *last)) return false;
    last = frame.time_s;
  }
  return true;
}

struct Listed {
  std::vector<dataset::ImagePair> pairs;
  std::vector<ParsedFrame> frames;
  std::vector<int> video_frames;
};

Listed ListFrames(const fs::path& folder,
                  const std::map<std::int64_t, ParsedFrame>& frames,
                  bool has_video,
                  bool has_times) {
  const auto depth = ImagesOf(folder, "depth", IsDepthName);
  const auto colour = ImagesOf(folder, "rgb", IsColourName);
  Listed listed;
  for (const auto& [number, frame] : frames) {
    const auto own_depth = depth.find(number);
    const auto own_colour = colour.find(number);
    if (own_depth == depth.end() || (!has_video && own_colour == colour.end())) continue;
    const double time_s = has_times ? *frame.time_s : TimeOfNumber(number);
    listed.pairs.push_back(
        {{time_s, has_video ? fmt::format("frame_{:06d}", number) : own_colour->second, 0},
         {time_s, own_depth->second, 0}});
    listed.frames.push_back(frame);
    listed.video_frames.push_back(static_cast<int>(number));
  }
  return listed;
}

Error NoFrames(const fs::path& folder) {
  std::error_code ignored;
  const bool packed = fs::is_regular_file(folder / "depth.bin", ignored);
  return InvalidInput(fmt::format(
      "{}: {}",
      folder.string(),
      packed ? "depth lies packed in depth.bin; unpack it to depth/frame_000000.png by the data "
               "set's iphone/prepare_iphone_data.py"
             : "no frame of pose_intrinsic_imu.json has a depth image (depth/frame_000000.png) and "
               "a colour image (rgb/frame_000000.jpg, or rgb.mkv); is it unpacked completely?"));
}

PinholeCamera CameraOf(const ParsedFrame& frame, const dataset::ImageSize& size) {
  return {size.width, size.height, frame.fx, frame.fy, frame.cx, frame.cy};
}

}  // namespace

LayoutMatch MatchScanNetPp(const fs::path& path) {
  std::error_code ignored;
  const bool has_colour =
      FindVideo(path, kVideos).has_value() || fs::is_directory(path / "rgb", ignored);
  LayoutMatch match =
      MatchOfPieces({{fs::is_regular_file(path / kName, ignored), "pose_intrinsic_imu.json"},
                     {fs::is_directory(path / "depth", ignored), "depth/"},
                     {has_colour, "rgb/ (or rgb.mkv)"}});
  match.matches = fs::is_regular_file(path / kName, ignored) && has_colour;
  return match;
}

Result<OpenedLayout> OpenScanNetPp(const LayoutSource& source) {
  const fs::path& folder = source.path;
  std::vector<std::string> warnings;
  Result<std::string> text = dataset::ReadTextFile(folder / kName);
  if (!text) return text.error();
  const auto frames = ParseFrames(*text, folder / kName);
  if (!frames) return frames.error();
  std::error_code ignored;
  const bool has_images = fs::is_directory(folder / "rgb", ignored);
  const std::optional<fs::path> video = has_images ? std::nullopt : FindVideo(folder, kVideos);
  FilesOfLayout files{
      "scannetpp", {{"frames", *text}}, {}, {}, (folder / kName).string(), {}, {}, false};
  files.has_times = HasTimes(*frames);
  Listed listed = ListFrames(folder, *frames, video.has_value(), files.has_times);
  if (listed.pairs.empty()) return NoFrames(folder);
  files.pairs = std::move(listed.pairs);
  dataset::ImageForm form;
  dataset::ImageSize size;
  if (video) {
    const Result<VideoColour> opened = OpenVideoColour(*video);
    if (!opened) return opened.error();
    form.video = opened->video;
    form.video_frames = std::move(listed.video_frames);
    size = {form.video->width(), form.video->height()};
    files.texts.emplace_back("video", opened->digest);
  } else {
    const Result<dataset::ImageSize> first = FirstColourSize(folder, files.pairs);
    if (!first) return first.error();
    size = *first;
  }
  for (const ParsedFrame& frame : listed.frames) {
    files.poses.push_back(frame.world_from_camera);
    files.optics.colour_cameras.push_back(CameraOf(frame, size));
    const Status plausible =
        dataset::CheckCamera(files.optics.colour_cameras.back(), folder / kName, "intrinsic");
    if (!plausible) return plausible.error();
  }
  const PinholeCamera& camera = files.optics.colour_cameras.front();
  Result<SettledImages> settled = SettleImages(
      source, {camera, camera, Pose3(), kUnitsPerM}, files.pairs, warnings, CoarserDepth::kUsual);
  if (!settled) return settled.error();
  form.raw_per_real = settled->form.raw_per_real;
  files.settled = {settled->cameras, std::move(form)};
  return OpenFiles(source, std::move(files), std::move(warnings));
}

}  // namespace deepslam::layouts
