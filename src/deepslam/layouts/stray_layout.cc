// Exports of phone apps that record ARKit's depth, in the layout of Stray Scanner: colour as a
// video (or a folder of images), depth in millimetres with a confidence (0 low, 1 medium, 2 high)
// per pixel, both coarser than colour and seen from its place. odometry.csv has world from camera,
// the camera's axes x right, y down, z forward.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/every_nth.h"
#include "deepslam/dataset/file_frames.h"
#include "deepslam/dataset/read_bytes.h"
#include "deepslam/dataset/video_file.h"
#include "deepslam/layouts/layout.h"
#include "deepslam/layouts/text_lines.h"
#include "deepslam/layouts/tum_layout.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

constexpr double kUnitsPerM = 1000;
constexpr int kMinConfidence = 1;
constexpr double kMaxFocalSpread = 0.01;
constexpr double kMaxPositionM = 1e6;
constexpr std::string_view kVideoName = "rgb.mp4";
constexpr std::string_view kOdometryName = "odometry.csv";
constexpr std::string_view kMatrixName = "camera_matrix.csv";
constexpr std::string_view kArrayEnd = ".npy";

// A row of odometry.csv.
struct Row {
  double time_s = 0;
  std::int64_t frame = 0;
  std::optional<Pose3> world_from_camera;
  double fx = 0;  // 0: not stated
};

// Columns of odometry.csv by name; newer versions of the app added some.
struct Columns {
  std::map<std::string, std::size_t, std::less<>> at;

  [[nodiscard]] std::optional<std::size_t> Find(std::string_view name) const {
    const auto found = at.find(name);
    return found == at.end() ? std::nullopt : std::optional(found->second);
  }
};

Result<Columns> ParseColumns(const std::vector<TextLine>& lines, const fs::path& file) {
  Columns columns;
  if (lines.empty()) return InvalidInput(fmt::format("{}: is empty", file.string()));
  for (std::size_t i = 0; i < lines.front().fields.size(); ++i)
    columns.at.emplace(lines.front().fields[i], i);
  for (const char* name : {"x", "y", "z", "qx", "qy", "qz", "qw"}) {
    if (columns.Find(name)) continue;
    return LineError(
        file,
        lines.front().number,
        fmt::format("column '{}' is missing; the first line reads 'timestamp, frame, x, y, z, qx, "
                    "qy, qz, qw'",
                    name));
  }
  return columns;
}

Result<double> Field(const fs::path& file,
                     const TextLine& line,
                     const Columns& columns,
                     std::string_view name) {
  const std::size_t column = *columns.Find(name);
  if (column >= line.fields.size())
    return LineError(file, line.number, fmt::format("column '{}' is missing (truncated?)", name));
  const std::optional<double> number = ParseNumber(line.fields[column]);
  if (!number) {
    return LineError(
        file,
        line.number,
        fmt::format("field '{}' is '{}', not a number", name, Shown(line.fields[column])));
  }
  return *number;
}

Result<Row> ParseRow(const fs::path& file,
                     const TextLine& line,
                     const Columns& columns,
                     std::size_t position) {
  Row row;
  row.frame = static_cast<std::int64_t>(position);
  row.time_s = TimeOfNumber(row.frame);
  if (columns.Find("frame")) {
    const Result<double> frame = Field(file, line, columns, "frame");
    if (!frame) return frame.error();
    if (!(*frame >= 0 && *frame < 1e9 && *frame == std::floor(*frame)))
      return LineError(file, line.number, fmt::format("field 'frame' is {}", *frame));
    row.frame = static_cast<std::int64_t>(*frame);
  }
  if (columns.Find("timestamp")) {
    const Result<double> time_s = Field(file, line, columns, "timestamp");
    if (!time_s) return time_s.error();
    if (!(std::abs(*time_s) < 1e11))
      return LineError(file, line.number, fmt::format("field 'timestamp' is {}", *time_s));
    row.time_s = *time_s;
  }
  Eigen::Matrix<double, 7, 1> pose;
  int i = 0;
  for (const char* name : {"x", "y", "z", "qx", "qy", "qz", "qw"}) {
    const Result<double> number = Field(file, line, columns, name);
    if (!number) return number.error();
    pose[i++] = *number;
  }
  const double norm = pose.tail<4>().norm();
  if (pose.allFinite() && norm > 0.5 && norm < 2.0 &&
      pose.head<3>().cwiseAbs().maxCoeff() < kMaxPositionM) {
    row.world_from_camera =
        Pose3{Eigen::Quaterniond(pose[6], pose[3], pose[4], pose[5]).normalized(), pose.head<3>()};
  }
  if (const auto fx = columns.Find("fx"); fx && *fx < line.fields.size())
    row.fx = ParseNumber(line.fields[*fx]).value_or(0);
  return row;
}

Result<std::vector<Row>> ParseOdometry(const std::string& text, const fs::path& file) {
  const std::vector<TextLine> lines = SplitLines(text);
  const Result<Columns> columns = ParseColumns(lines, file);
  if (!columns) return columns.error();
  std::vector<Row> rows;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const Result<Row> row = ParseRow(file, lines[i], *columns, i - 1);
    if (!row) return row.error();
    if (!rows.empty() && row->frame <= rows.back().frame)
      return LineError(file, lines[i].number, "field 'frame' does not ascend: sort the lines");
    rows.push_back(*row);
  }
  if (rows.empty()) return InvalidInput(fmt::format("{}: lists no frames", file.string()));
  return rows;
}

Result<PinholeCamera> ReadMatrix(const fs::path& file, const dataset::ImageSize& size) {
  const Result<std::string> text = dataset::ReadFileBytes(file);
  if (!text) return text.error();
  const auto m = ParseNumbers(*text, file, 9, "a 3 x 3 matrix");
  if (!m) return m.error();
  const PinholeCamera camera{size.width, size.height, (*m)[0], (*m)[4], (*m)[2], (*m)[5]};
  const Status plausible = dataset::CheckCamera(camera, file);
  if (!plausible) return plausible.error();
  return camera;
}

// The phone refocuses as it records; one camera stands for all frames.
void WarnOfFocus(const std::vector<Row>& rows,
                 const PinholeCamera& camera,
                 const fs::path& file,
                 std::vector<std::string>& warnings) {
  double worst = 0;
  for (const Row& row : rows) {
    if (row.fx > 0) worst = std::max(worst, std::abs(row.fx / camera.fx - 1));
  }
  if (worst > kMaxFocalSpread) {
    warnings.push_back(
        fmt::format("{}: the focal length of single frames differs by up to {:.1f} % from that of "
                    "camera_matrix.csv, which is used for all",
                    file.string(),
                    100 * worst));
  }
}

// Names of a folder's images by the number in them.
std::map<std::int64_t, std::string> ByNumber(const fs::path& folder) {
  std::map<std::int64_t, std::string> names;
  for (const std::string& name : dataset::ListFiles(folder)) {
    if (name.ends_with(kArrayEnd)) continue;
    const std::string stem = fs::path(name).stem().string();
    if (stem.empty() || stem.size() > 9 ||
        stem.find_first_not_of("0123456789") != std::string::npos) {
      continue;
    }
    names.emplace(std::stol(stem), name);
  }
  return names;
}

class StrayFrames final : public dataset::StoredFrames {
 public:
  struct Files {
    std::int64_t video_index = 0;
    std::string colour;  // empty: in the video
    std::string depth;
    std::string confidence;  // empty: none
  };

  StrayFrames(fs::path folder,
              const dataset::CaptureCameras& cameras,
              std::vector<dataset::StoredFrame> frames,
              std::vector<Files> files,
              std::shared_ptr<dataset::VideoFile> video,
              int min_confidence)
      : dataset::StoredFrames(cameras, std::move(frames)),
        folder_(std::move(folder)),
        files_(std::move(files)),
        video_(std::move(video)),
        min_confidence_(min_confidence) {}

  [[nodiscard]] Result<dataset::StoredColour> ReadColour(std::size_t i) const override {
    const Files& files = files_[i];
    dataset::StoredColour colour;
    if (files.colour.empty()) {
      colour.name = fmt::format("{}, frame {}", (folder_ / kVideoName).string(), files.video_index);
      Result<ColourImage> pixels = video_->Read(static_cast<int>(files.video_index));
      if (!pixels) return pixels.error();
      colour.pixels = *std::move(pixels);
      return colour;
    }
    const fs::path file = folder_ / files.colour;
    Result<std::string> bytes = dataset::ReadFileBytes(file);
    if (!bytes) return bytes.error();
    colour = {dataset::CodecOf(*bytes), *std::move(bytes), ColourImage(), file.string()};
    if (colour.codec == dataset::ImageCodec::kOther)
      return InvalidInput(file.string() + ": is neither a PNG nor a JPEG image");
    return colour;
  }

  [[nodiscard]] Result<RawDepthImage> ReadDepth(std::size_t i) const override {
    const Files& files = files_[i];
    const PinholeCamera& camera = cameras().depth;
    Result<RawDepthImage> depth =
        dataset::ReadDepthFile(folder_ / files.depth, camera.width, camera.height);
    if (!depth || files.confidence.empty() || min_confidence_ <= 0) return depth;
    const Result<Image<std::uint8_t>> confidence =
        dataset::ReadGreyFile(folder_ / files.confidence, camera.width, camera.height);
    if (!confidence) return confidence.error();
    std::transform(depth->begin(),
                   depth->end(),
                   confidence->begin(),
                   depth->begin(),
                   [&](std::uint16_t raw, std::uint8_t sure) {
                     return sure < min_confidence_ ? kNoDepth : raw;
                   });
    return depth;
  }

  [[nodiscard]] std::shared_ptr<const dataset::StoredFrames> Every(
      std::size_t step) const override {
    return std::make_shared<StrayFrames>(folder_,
                                         cameras(),
                                         EveryNth(frames(), step),
                                         EveryNth(files_, step),
                                         video_,
                                         min_confidence_);
  }

 private:
  fs::path folder_;
  std::vector<Files> files_;
  std::shared_ptr<dataset::VideoFile> video_;
  int min_confidence_;
};

struct Listed {
  std::vector<dataset::StoredFrame> frames;
  std::vector<StrayFrames::Files> files;
};

// The rows of odometry.csv that have a depth image, and a colour image where those are files.
Result<Listed> ListFrames(const fs::path& folder,
                          const std::vector<Row>& rows,
                          bool has_video,
                          std::vector<std::string>& warnings) {
  const auto depth = ByNumber(folder / "depth");
  const auto confidence = ByNumber(folder / "confidence");
  const auto colour = has_video ? std::map<std::int64_t, std::string>() : ByNumber(folder / "rgb");
  Listed listed;
  std::size_t num_unsure = 0;
  std::size_t num_missing = 0;
  std::string first_missing;
  for (const Row& row : rows) {
    const auto depth_file = depth.find(row.frame);
    const auto colour_file = colour.find(row.frame);
    const bool colour_missing = !has_video && colour_file == colour.end();
    if (depth_file == depth.end() || colour_missing) {
      if (num_missing++ == 0) {
        first_missing = fmt::format("{}/{:06d}.{}",
                                    colour_missing ? "rgb" : "depth",
                                    row.frame,
                                    colour_missing ? "jpg" : "png");
      }
      continue;
    }
    StrayFrames::Files files{row.frame, {}, "depth/" + depth_file->second, {}};
    if (!has_video) files.colour = "rgb/" + colour_file->second;
    if (const auto sure = confidence.find(row.frame); sure != confidence.end()) {
      files.confidence = "confidence/" + sure->second;
    } else {
      ++num_unsure;
    }
    listed.frames.push_back({row.time_s,
                             row.time_s,
                             has_video ? fmt::format("{:06d}", row.frame) : files.colour,
                             row.world_from_camera});
    listed.files.push_back(std::move(files));
  }
  if (num_missing > 0) {
    const std::string what = fmt::format("{}: file is missing; {} of {} frames of {} lack an image",
                                         (folder / first_missing).string(),
                                         num_missing,
                                         rows.size(),
                                         kOdometryName);
    const std::vector<std::string> depth_files = dataset::ListFiles(folder / "depth");
    if (depth.empty() && !depth_files.empty() && depth_files.front().ends_with(kArrayEnd)) {
      return InvalidInput(
          fmt::format("{}: depth as .npy (the app's first versions) is not read; convert it to "
                      "16-bit PNG files, "
                      "depth/000000.png ..., in millimetres",
                      (folder / "depth" / depth_files.front()).string()));
    }
    if (2 * num_missing > rows.size())
      return InvalidInput(what + ": is the capture unpacked completely?");
    warnings.push_back(what + " and are skipped");
  }
  if (num_unsure > 0) {
    warnings.push_back(
        fmt::format("{}: {} of {} frames have no confidence map; all their depth is kept",
                    folder.string(),
                    num_unsure,
                    listed.frames.size()));
  }
  return listed;
}

// The same view with images of another size.
PinholeCamera Resized(const PinholeCamera& camera, const dataset::ImageSize& size) {
  const double sx = static_cast<double>(size.width) / camera.width;
  const double sy = static_cast<double>(size.height) / camera.height;
  return {size.width,
          size.height,
          camera.fx * sx,
          camera.fy * sy,
          (camera.cx + 0.5) * sx - 0.5,
          (camera.cy + 0.5) * sy - 0.5};
}

// Of the first file that has one; without any, why the first of all has none.
Result<dataset::ImageSize> FirstSize(const fs::path& folder,
                                     const std::vector<StrayFrames::Files>& files,
                                     std::string StrayFrames::Files::*image) {
  std::optional<Error> first_error;
  for (const StrayFrames::Files& of_frame : files) {
    const Result<dataset::ImageSize> size = dataset::ReadImageSize(folder / (of_frame.*image));
    if (size) return size;
    if (!first_error) first_error = size.error();
  }
  return *first_error;
}

Result<std::string> HashOf(const LayoutSource& source,
                           const std::vector<dataset::NamedText>& texts,
                           const Listed& listed) {
  std::vector<dataset::ImagePair> pairs;
  for (std::size_t i = 0; i < listed.files.size(); ++i) {
    const StrayFrames::Files& files = listed.files[i];
    const double time_s = listed.frames[i].depth_time_s;
    pairs.push_back({{time_s, files.confidence.empty() ? files.depth : files.confidence, 0},
                     {time_s, files.depth, 0}});
    if (!files.colour.empty())
      pairs.push_back({{time_s, files.colour, 0}, {time_s, files.depth, 0}});
  }
  return dataset::HashFiles("stray", texts, source.path, pairs);
}

}  // namespace

LayoutMatch MatchStray(const fs::path& path) {
  LayoutMatch match;
  std::error_code ignored;
  const bool has_odometry = fs::exists(path / kOdometryName, ignored);
  const bool has_colour =
      fs::exists(path / kVideoName, ignored) || fs::is_directory(path / "rgb", ignored);
  for (const auto& [found, piece] : {std::pair(has_odometry, "odometry.csv"),
                                     {fs::exists(path / kMatrixName, ignored), "camera_matrix.csv"},
                                     {has_colour, "rgb.mp4 (or rgb/)"},
                                     {fs::is_directory(path / "depth", ignored), "depth/"}}) {
    if (found) {
      ++match.num_found;
    } else {
      match.missing.emplace_back(piece);
    }
  }
  // A folder with lists of files is a TUM capture, whatever else lies in it.
  match.matches = ListsOf(path).empty() &&
                  (has_odometry || (has_colour && fs::exists(path / kMatrixName, ignored)));
  return match;
}

Result<OpenedLayout> OpenStray(const LayoutSource& source) {
  const fs::path& folder = source.path;
  OpenedLayout opened;
  Result<std::string> odometry_text = dataset::ReadFileBytes(folder / kOdometryName);
  if (!odometry_text) return odometry_text.error();
  const Result<std::vector<Row>> rows = ParseOdometry(*odometry_text, folder / kOdometryName);
  if (!rows) return rows.error();

  std::error_code ignored;
  const bool has_video = fs::exists(folder / kVideoName, ignored);
  Result<Listed> listed = ListFrames(folder, *rows, has_video, opened.warnings);
  if (!listed) return listed.error();
  const Result<dataset::ImageSize> depth_size =
      FirstSize(folder, listed->files, &StrayFrames::Files::depth);
  if (!depth_size) return depth_size.error();
  std::shared_ptr<dataset::VideoFile> video;
  dataset::ImageSize colour_size;
  std::optional<std::string> video_digest;
  if (has_video) {
    Result<std::unique_ptr<dataset::VideoFile>> opened_video =
        dataset::VideoFile::Open(folder / kVideoName);
    if (!opened_video) return opened_video.error();
    video = *std::move(opened_video);
    colour_size = {video->width(), video->height()};
    Result<std::string> digest = dataset::HashLargeFile(folder / kVideoName);
    if (!digest) return digest.error();
    video_digest = *std::move(digest);
  } else {
    const Result<dataset::ImageSize> size =
        FirstSize(folder, listed->files, &StrayFrames::Files::colour);
    if (!size) return size.error();
    colour_size = *size;
  }
  dataset::CaptureCameras cameras;
  cameras.depth_units_per_m = kUnitsPerM;
  std::optional<std::string> matrix_text;
  if (source.settings.has_camera()) {
    cameras.colour = source.settings.camera;
  } else {
    const Result<PinholeCamera> camera = ReadMatrix(folder / kMatrixName, colour_size);
    if (!camera) return camera.error();
    cameras.colour = *camera;
    WarnOfFocus(*rows, *camera, folder / kOdometryName, opened.warnings);
    const Result<std::optional<std::string>> text = dataset::ReadOptional(folder / kMatrixName);
    if (text) matrix_text = *text;
  }
  cameras.depth = source.settings.depth_camera.value_or(Resized(cameras.colour, *depth_size));
  cameras.colour_from_depth = source.settings.colour_from_depth.value_or(Pose3());
  if (source.settings.depth_units_per_m > 0)
    cameras.depth_units_per_m = source.settings.depth_units_per_m;

  Result<std::string> hash = HashOf(source,
                                    {{kSettingsName, source.settings_text},
                                     {kOdometryName, *odometry_text},
                                     {kMatrixName, matrix_text},
                                     {kVideoName, video_digest}},
                                    *listed);
  if (!hash) return hash.error();
  opened.content_hash = *std::move(hash);
  opened.frames =
      std::make_shared<StrayFrames>(folder,
                                    cameras,
                                    std::move(listed->frames),
                                    std::move(listed->files),
                                    std::move(video),
                                    source.settings.min_confidence.value_or(kMinConfidence));
  return opened;
}

}  // namespace deepslam::layouts
