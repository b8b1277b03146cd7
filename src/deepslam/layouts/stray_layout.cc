// Exports of phone apps that record ARKit's depth, in the layout of Stray Scanner: colour as a
// video (or a folder of images), depth in millimetres with a confidence (0 low, 1 medium, 2 high)
// per pixel, both coarser than colour and seen from its place. odometry.csv has world from camera,
// the camera's axes x right, y down, z forward.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/dataset/read_bytes.h"
#include "deepslam/formats/text_lines.h"
#include "deepslam/geometry/max_position.h"
#include "deepslam/layouts/image_folders.h"
#include "deepslam/layouts/open_files.h"
#include "deepslam/layouts/tum_layout.h"
#include "deepslam/layouts/video_colour.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

constexpr double kUnitsPerM = 1000;  // millimetres, as the app writes them
constexpr int kMinConfidence = 1;    // of 0, 1 and 2 (ARKit's ARConfidenceLevel): medium
constexpr std::array<std::string_view, 3> kVideos = {"rgb.mp4", "rgb.mov", "rgb.m4v"};
constexpr std::string_view kOdometryName = "odometry.csv";
constexpr std::string_view kMatrixName = "camera_matrix.csv";

// A row of odometry.csv.
struct Row {
  double time_s = 0;
  std::int64_t frame = 0;
  std::optional<Pose3> world_from_camera;
  std::optional<std::array<double, 4>> intrinsics;  // fx fy cx cy of this frame, px
};

// Columns of odometry.csv by name; newer versions of the app added some.
struct Columns {
  std::map<std::string, std::size_t, std::less<>> at;

  [[nodiscard]] std::optional<std::size_t> Find(std::string_view name) const {
    const auto found = at.find(name);
    return found == at.end() ? std::nullopt : std::optional(found->second);
  }
};

Result<Columns> ParseColumns(const std::vector<formats::TextLine>& lines, const fs::path& file) {
  Columns columns;
  if (lines.empty()) return InvalidInput(fmt::format("{}: is empty", file.string()));
  for (std::size_t i = 0; i < lines.front().fields.size(); ++i)
    columns.at.emplace(lines.front().fields[i], i);
  for (const char* name : {"x", "y", "z", "qx", "qy", "qz", "qw"}) {
    if (columns.Find(name)) continue;
    return formats::LineError(
        file,
        lines.front().number,
        fmt::format("column '{}' is missing; the first line reads 'timestamp, frame, x, y, z, qx, "
                    "qy, qz, qw'",
                    name));
  }
  return columns;
}

Result<double> Field(const fs::path& file,
                     const formats::TextLine& line,
                     const Columns& columns,
                     std::string_view name) {
  const std::size_t column = *columns.Find(name);
  if (column >= line.fields.size())
    return formats::LineError(
        file, line.number, fmt::format("column '{}' is missing (truncated?)", name));
  const std::optional<double> number = formats::ParseNumber(line.fields[column]);
  if (!number) {
    return formats::LineError(
        file,
        line.number,
        fmt::format("field '{}' is '{}', not a number", name, formats::Shown(line.fields[column])));
  }
  return *number;
}

// Nothing where the app has not written them.
std::optional<std::array<double, 4>> ParseIntrinsics(const formats::TextLine& line,
                                                     const Columns& columns) {
  std::array<double, 4> numbers{};
  std::size_t i = 0;
  for (const char* name : {"fx", "fy", "cx", "cy"}) {
    const std::optional<std::size_t> column = columns.Find(name);
    if (!column || *column >= line.fields.size()) return std::nullopt;
    const std::optional<double> number = formats::ParseNumber(line.fields[*column]);
    if (!number || !(*number > 0)) return std::nullopt;
    numbers[i++] = *number;
  }
  return numbers;
}

Result<Row> ParseRow(const fs::path& file,
                     const formats::TextLine& line,
                     const Columns& columns,
                     std::size_t position) {
  Row row;
  row.frame = static_cast<std::int64_t>(position);
  row.time_s = TimeOfNumber(row.frame);
  if (columns.Find("frame")) {
    const Result<double> frame = Field(file, line, columns, "frame");
    if (!frame) return frame.error();
    if (!(*frame >= 0 && *frame < 1e9 && *frame == std::floor(*frame)))
      return formats::LineError(file, line.number, fmt::format("field 'frame' is {}", *frame));
    row.frame = static_cast<std::int64_t>(*frame);
  }
  if (columns.Find("timestamp")) {
    const Result<double> time_s = Field(file, line, columns, "timestamp");
    if (!time_s) return time_s.error();
    if (!(std::abs(*time_s) < 1e11))
      return formats::TimeError(
          file, line.number, "timestamp", line.fields[*columns.Find("timestamp")]);
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
  row.intrinsics = ParseIntrinsics(line, columns);
  return row;
}

Result<std::vector<Row>> ParseOdometry(const std::string& text,
                                       const fs::path& file,
                                       std::vector<std::string>& warnings) {
  const std::vector<formats::TextLine> lines = formats::SplitLines(text);
  const Result<Columns> columns = ParseColumns(lines, file);
  if (!columns) return columns.error();
  std::vector<Row> rows;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const Result<Row> row = ParseRow(file, lines[i], *columns, i - 1);
    if (!row && formats::IsLeftOut(file, lines[i], warnings)) break;
    if (!row) return row.error();
    if (!rows.empty() && row->frame <= rows.back().frame)
      return formats::LineError(
          file, lines[i].number, "field 'frame' does not ascend: sort the lines");
    rows.push_back(*row);
  }
  if (rows.empty()) return InvalidInput(fmt::format("{}: lists no frames", file.string()));
  return rows;
}

Result<PinholeCamera> ReadMatrix(const fs::path& file, const dataset::ImageSize& size) {
  const Result<std::string> text = dataset::ReadTextFile(file);
  if (!text) return text.error();
  const auto m = formats::ParseNumbers(*text, file, 9, "a 3 x 3 matrix");
  if (!m) return m.error();
  const PinholeCamera camera{size.width, size.height, (*m)[0], (*m)[4], (*m)[2], (*m)[5]};
  const Status plausible = dataset::CheckCamera(camera, file);
  if (!plausible) return plausible.error();
  return camera;
}

// Files of frames by the number in odometry.csv.
using ByFrame = std::map<std::int64_t, std::string>;

// By how much the files of as many images as there are rows are numbered higher; nothing where not
// all differ by one amount.
std::optional<std::int64_t> ShiftOf(const ByFrame& files, const std::vector<Row>& rows) {
  if (files.size() != rows.size()) return std::nullopt;
  const std::int64_t shift = files.begin()->first - rows.front().frame;
  auto file = files.begin();
  for (const Row& row : rows) {
    if (file->first - row.frame != shift) return std::nullopt;
    ++file;
  }
  return shift;
}

// Images of a folder. Those that are numbered from elsewhere than the rows (ffmpeg counts from 1)
// are taken in order.
ByFrame FilesOfRows(const fs::path& folder,
                    bool (*is_image)(std::string_view),
                    const std::vector<Row>& rows,
                    std::vector<std::string>& warnings) {
  ByFrame files = FilesByNumber(folder, is_image);
  const std::int64_t shift = files.empty() ? 0 : ShiftOf(files, rows).value_or(0);
  if (shift == 0) return files;
  warnings.push_back(fmt::format(
      "{}: is numbered from {}, {} from {}; as many of both, so they were paired in order (ffmpeg "
      "counts from 1 unless told -start_number 0)",
      folder.string(),
      files.begin()->first,
      kOdometryName,
      rows.front().frame));
  ByFrame shifted;
  for (auto& [number, name] : files) shifted.emplace(number - shift, std::move(name));
  return shifted;
}

struct Listed {
  std::vector<dataset::ImagePair> pairs;
  formats::FramePoses poses;
  std::vector<std::string> confidence;
  std::vector<int> video_frames;
  std::vector<Row> rows;
};

std::string MissingName(const Row& row, bool colour) {
  return fmt::format("{}/{:06d}.{}", colour ? "rgb" : "depth", row.frame, colour ? "jpg" : "png");
}

// The rows of odometry.csv that have a depth image, and a colour image where those are files.
Result<Listed> ListFrames(const fs::path& folder,
                          const std::vector<Row>& rows,
                          bool has_video,
                          std::vector<std::string>& warnings) {
  const ByFrame depth = FilesOfRows(folder / "depth", IsDepthName, rows, warnings);
  const ByFrame confidence = FilesOfRows(folder / "confidence", IsColourName, rows, warnings);
  const ByFrame colour =
      has_video ? ByFrame() : FilesOfRows(folder / "rgb", IsColourName, rows, warnings);
  Listed listed;
  std::size_t num_unsure = 0;
  std::string first_missing;
  for (const Row& row : rows) {
    const auto depth_file = depth.find(row.frame);
    const auto colour_file = colour.find(row.frame);
    const bool colour_missing = !has_video && colour_file == colour.end();
    if (depth_file == depth.end() || colour_missing) {
      if (first_missing.empty()) first_missing = MissingName(row, colour_missing);
      continue;
    }
    listed.pairs.push_back(
        {{row.time_s,
          has_video ? fmt::format("{:06d}", row.frame) : "rgb/" + colour_file->second,
          0},
         {row.time_s, "depth/" + depth_file->second, 0}});
    listed.poses.push_back(row.world_from_camera);
    listed.rows.push_back(row);
    const auto sure = confidence.find(row.frame);
    if (sure == confidence.end()) ++num_unsure;
    listed.confidence.push_back(sure == confidence.end() ? "" : "confidence/" + sure->second);
  }
  if (const std::size_t num_missing = rows.size() - listed.pairs.size(); num_missing > 0) {
    const std::string what = fmt::format("{}: file is missing; {} of {} frames of {} lack an image",
                                         (folder / first_missing).string(),
                                         num_missing,
                                         rows.size(),
                                         kOdometryName);
    if (2 * num_missing > rows.size())
      return InvalidInput(what + ": is the capture unpacked completely?");
    warnings.push_back(what + " and are skipped");
  }
  if (num_unsure > 0) {
    warnings.push_back(
        fmt::format("{}: {} of {} frames have no confidence map; all their depth is kept",
                    folder.string(),
                    num_unsure,
                    listed.pairs.size()));
  }
  return listed;
}

// Which frame of the video belongs to each row: that of its number; where the video has as many as
// there are rows and these are numbered beyond its end, those in order. Rows behind its end are
// dropped.
void SetVideoFrames(const dataset::VideoFile& video,
                    const std::vector<Row>& rows,
                    Listed& listed,
                    std::vector<std::string>& warnings,
                    std::vector<std::string>& doubts) {
  const std::int64_t num_frames = video.num_frames();
  const bool behind_end = num_frames > 0 && rows.back().frame >= num_frames;
  const bool in_order = behind_end && num_frames == static_cast<std::int64_t>(rows.size());
  if (in_order) {
    warnings.push_back(
        fmt::format("{}: {} has frames {} to {} and the video has as many frames as it has rows; "
                    "they were paired in order",
                    video.file().string(),
                    kOdometryName,
                    rows.front().frame,
                    rows.back().frame));
  } else if (behind_end) {
    doubts.push_back(fmt::format(
        "{}: the video has {} frames, {} goes up to frame {}: where frames are missing in it, "
        "colour is late against depth from there on; extract it anew",
        video.file().string(),
        num_frames,
        kOdometryName,
        rows.back().frame));
  }
  Listed kept;
  for (std::size_t i = 0; i < listed.pairs.size(); ++i) {
    const std::int64_t frame = listed.rows[i].frame;
    const std::int64_t index =
        in_order ? std::ranges::lower_bound(rows, frame, {}, &Row::frame) - rows.begin() : frame;
    if (num_frames > 0 && index >= num_frames) continue;
    kept.pairs.push_back(std::move(listed.pairs[i]));
    kept.poses.push_back(listed.poses[i]);
    kept.confidence.push_back(std::move(listed.confidence[i]));
    kept.rows.push_back(listed.rows[i]);
    kept.video_frames.push_back(static_cast<int>(index));
  }
  listed = std::move(kept);
}

// The phone refocuses as it records: newer versions of the app write each frame's own intrinsics.
Result<std::vector<PinholeCamera>> CamerasOfRows(const std::vector<Row>& rows,
                                                 const PinholeCamera& camera,
                                                 const fs::path& file) {
  std::vector<PinholeCamera> cameras;
  for (const Row& row : rows) {
    if (!row.intrinsics) return std::vector<PinholeCamera>();
    PinholeCamera own = camera;
    own.fx = (*row.intrinsics)[0];
    own.fy = (*row.intrinsics)[1];
    own.cx = (*row.intrinsics)[2];
    own.cy = (*row.intrinsics)[3];
    const Status plausible = dataset::CheckCamera(own, file, "fx, fy, cx, cy");
    if (!plausible) return plausible.error();
    cameras.push_back(own);
  }
  return cameras;
}

}  // namespace

LayoutMatch MatchStray(const fs::path& path) {
  std::error_code ignored;
  const bool has_odometry = fs::exists(path / kOdometryName, ignored);
  const bool has_colour = FindVideo(path, kVideos) || fs::is_directory(path / "rgb", ignored);
  LayoutMatch match = MatchOfPieces({{has_odometry, "odometry.csv"},
                                     {fs::exists(path / kMatrixName, ignored), "camera_matrix.csv"},
                                     {has_colour, "rgb.mp4 (or rgb/)"},
                                     {fs::is_directory(path / "depth", ignored), "depth/"}});
  // A folder with lists of files is a TUM capture, whatever else lies in it.
  match.matches = ListsOf(path).empty() &&
                  (has_odometry || (has_colour && fs::exists(path / kMatrixName, ignored)));
  return match;
}

Result<OpenedLayout> OpenStray(const LayoutSource& source) {
  const fs::path& folder = source.path;
  std::vector<std::string> warnings, doubts;
  Result<std::string> odometry_text = dataset::ReadTextFile(folder / kOdometryName);
  if (!odometry_text) return odometry_text.error();
  const Result<std::vector<Row>> rows =
      ParseOdometry(*odometry_text, folder / kOdometryName, warnings);
  if (!rows) return rows.error();
  const std::optional<fs::path> video = FindVideo(folder, kVideos);
  Result<Listed> listed = ListFrames(folder, *rows, video.has_value(), warnings);
  if (!listed) return listed.error();
  FilesOfLayout files{"stray",
                      {{kOdometryName, *odometry_text}},
                      {},
                      {},
                      (folder / kOdometryName).string(),
                      {},
                      {},
                      true};
  dataset::ImageForm form;
  dataset::ImageSize colour_size;
  if (video) {
    const Result<VideoColour> opened = OpenVideoColour(*video);
    if (!opened) return opened.error();
    SetVideoFrames(*opened->video, *rows, *listed, warnings, doubts);
    form.video = opened->video;
    form.video_frames = std::move(listed->video_frames);
    colour_size = {form.video->width(), form.video->height()};
    files.texts.emplace_back(kVideos[0], opened->digest);
  } else {
    const Result<dataset::ImageSize> size = FirstColourSize(folder, listed->pairs);
    if (!size) return size.error();
    colour_size = *size;
  }
  PinholeCamera camera;
  if (!source.settings.has_camera()) {
    const Result<PinholeCamera> own = ReadMatrix(folder / kMatrixName, colour_size);
    if (!own) return own.error();
    camera = *own;
    Result<std::vector<PinholeCamera>> of_rows =
        CamerasOfRows(listed->rows, camera, folder / kOdometryName);
    if (!of_rows) return of_rows.error();
    files.optics.colour_cameras = *std::move(of_rows);
    const Result<std::optional<std::string>> text = dataset::ReadOptional(folder / kMatrixName);
    if (text) files.texts.emplace_back(kMatrixName, *text);
  }
  Result<SettledImages> settled = SettleImages(
      source, {camera, camera, Pose3(), kUnitsPerM}, listed->pairs, warnings, CoarserDepth::kUsual);
  if (!settled) return settled.error();
  form.raw_per_real = settled->form.raw_per_real;
  form.confidence = std::move(listed->confidence);
  form.min_confidence = source.settings.min_confidence.value_or(kMinConfidence);
  files.settled = {settled->cameras, std::move(form)};
  files.pairs = std::move(listed->pairs);
  files.poses = std::move(listed->poses);
  Result<OpenedLayout> opened = OpenFiles(source, std::move(files), std::move(warnings));
  if (opened) opened->doubts = std::move(doubts);
  return opened;
}

}  // namespace deepslam::layouts
