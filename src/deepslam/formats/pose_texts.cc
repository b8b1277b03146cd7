#include "deepslam/formats/pose_texts.h"

#include <algorithm>
#include <span>

#include <fmt/format.h>

#include "deepslam/dataset/file_frames.h"
#include "deepslam/formats/pose_matrix.h"
#include "deepslam/formats/text_lines.h"
#include "deepslam/geometry/max_position.h"

namespace deepslam::formats {
namespace {

namespace fs = std::filesystem;

std::optional<Pose3> PoseOfSeven(const std::array<double, 16>& numbers, bool w_first) {
  Eigen::Quaterniond rotation(numbers[6], numbers[3], numbers[4], numbers[5]);
  if (w_first) rotation = Eigen::Quaterniond(numbers[3], numbers[4], numbers[5], numbers[6]);
  const Eigen::Vector3d position_m(numbers[0], numbers[1], numbers[2]);
  const double norm = rotation.norm();
  if (!position_m.allFinite() || !(norm > 0.5 && norm < 2.0) ||
      position_m.cwiseAbs().maxCoeff() > kMaxPositionM) {
    return std::nullopt;
  }
  return Pose3{rotation.normalized(), position_m};
}

Result<std::array<double, 16>> NumbersOf(const fs::path& file, const TextLine& line) {
  std::array<double, 16> numbers{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
  for (std::size_t i = 0; i < line.fields.size(); ++i) {
    const std::optional<double> number = ParseNumber(line.fields[i]);
    if (!number) {
      return LineError(
          file, line.number, fmt::format("'{}' is not a number", Shown(line.fields[i])));
    }
    numbers[i] = *number;
  }
  return numbers;
}

// Of a line that may hold no pose: nothing.
Result<std::optional<Pose3>> ParsePose(const fs::path& file,
                                       const TextLine& line,
                                       PoseColumns columns) {
  if (columns == PoseColumns::kMatrix) {
    if (line.fields.size() != 12) {
      const Status count = CheckFieldCount(file, line, 16, "a 4 x 4 matrix, row by row");
      if (!count) return count.error();
    }
    const Result<std::array<double, 16>> numbers = NumbersOf(file, line);
    if (!numbers) return numbers.error();
    return PoseOfMatrix(*numbers);
  }
  const bool w_first = columns == PoseColumns::kXyzQuatWxyz;
  const Status count =
      CheckFieldCount(file, line, 7, w_first ? "x y z qw qx qy qz" : "x y z qx qy qz qw");
  if (!count) return count.error();
  const Result<std::array<double, 16>> numbers = NumbersOf(file, line);
  if (!numbers) return numbers.error();
  return PoseOfSeven(*numbers, w_first);
}

// Fewer numbers than `count`, of which the last may be half a one.
bool EndsEarly(std::string_view text, std::size_t count) {
  std::vector<std::string_view> fields;
  for (const TextLine& line : SplitLines(text))
    fields.insert(fields.end(), line.fields.begin(), line.fields.end());
  if (!fields.empty()) fields.pop_back();
  return fields.size() + 1 < count && std::ranges::all_of(fields, [](std::string_view field) {
           return ParseNumber(field).has_value();
         });
}

void WarnOfUnusable(std::size_t num_unusable,
                    const std::string& first,
                    std::vector<std::string>& warnings) {
  if (num_unusable == 0) return;
  warnings.push_back(
      fmt::format("{}: {} poses are not finite or no rotations and were left out, this one first",
                  first,
                  num_unusable));
}

}  // namespace

Pose3 OfOpenGlCamera(const Pose3& world_from_open_gl) {
  // Half a turn about x.
  const Pose3 open_gl_from_camera{Eigen::Quaterniond(0, 1, 0, 0), Eigen::Vector3d::Zero()};
  return world_from_open_gl * open_gl_from_camera;
}

Result<FramePoses> ParsePoseLines(const std::string& text,
                                  const fs::path& file,
                                  PoseColumns columns,
                                  std::vector<std::string>& warnings) {
  FramePoses poses;
  std::size_t num_unusable = 0;
  std::string first_unusable;
  LineReader lines(text);
  while (const TextLine* const line = lines.Next()) {
    const Result<std::optional<Pose3>> pose = ParsePose(file, *line, columns);
    if (!pose) {
      // A line that the file ends within is the last one: its frame has no pose.
      if (!IsLeftOut(file, *line, warnings)) return pose.error();
      poses.emplace_back();
      break;
    }
    poses.push_back(*pose);
    if (!*pose && num_unusable++ == 0)
      first_unusable = fmt::format("{}:{}", file.string(), line->number);
  }
  WarnOfUnusable(num_unusable, first_unusable, warnings);
  return poses;
}

Result<MatrixFiles> ReadMatrixFiles(const fs::path& folder,
                                    const std::vector<std::string>& names,
                                    std::vector<std::string>& warnings) {
  MatrixFiles read;
  std::size_t num_unusable = 0;
  std::string first_unusable;
  for (const std::string& name : names) {
    const Result<std::optional<std::string>> text = dataset::ReadOptional(folder / name);
    if (!text) return text.error();
    read.poses.emplace_back();
    if (!*text) continue;
    read.text += fmt::format("{}\n{}\n", name, **text);
    const auto numbers = ParseNumbers(**text, folder / name, 16, "a 4 x 4 matrix");
    if (!numbers) {
      // Of a recorder that was stopped, the last file is not whole.
      if (names.size() == 1 || name != names.back() || !EndsEarly(**text, 16))
        return numbers.error();
      warnings.push_back(numbers.error().message + " (was the recorder stopped?) It was left out");
      break;
    }
    read.poses.back() = PoseOfMatrix(std::span<const double, 16>(*numbers));
    if (!read.poses.back() && num_unusable++ == 0) first_unusable = (folder / name).string();
  }
  WarnOfUnusable(num_unusable, first_unusable, warnings);
  return read;
}

}  // namespace deepslam::formats
