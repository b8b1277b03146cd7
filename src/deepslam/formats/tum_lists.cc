#include "deepslam/formats/tum_lists.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numeric>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/clock_segments.h"
#include "deepslam/formats/text_lines.h"
#include "deepslam/geometry/max_position.h"

namespace deepslam::formats {
namespace {

// Epoch seconds are 1e9; beyond this a number is no time.
constexpr double kMaxTimeS = 1e11;
Result<double> ParseTime(const std::filesystem::path& list, int line, std::string_view field) {
  double value = 0;
  const auto [end, code] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (code != std::errc() || end != field.data() + field.size() || !(std::abs(value) <= kMaxTimeS))
    return TimeError(list, line, "time", field);
  return value;
}

Result<std::string> ParseFileName(const std::filesystem::path& list,
                                  int line,
                                  std::string_view field) {
  const auto fault = [&](std::string_view what) {
    return LineError(
        list,
        line,
        fmt::format("field 'file' is '{}', {}: write a path below the capture's folder",
                    Shown(field),
                    what));
  };
  if (field.find('\0') != std::string_view::npos) return fault("which holds a zero byte");
  if (field.find('\\') != std::string_view::npos) return fault("which holds a backslash");
  const std::filesystem::path path(field);
  if (path.is_absolute()) return fault("an absolute path");
  for (const std::filesystem::path& part : path) {
    if (part == "..") return fault("which leaves the capture");
  }
  return path.lexically_normal().generic_string();
}

Result<dataset::TimedFile> ParseTimedFile(const std::filesystem::path& list,
                                          const TextLine& line,
                                          std::size_t first) {
  const Result<double> time_s = ParseTime(list, line.number, line.fields[first]);
  if (!time_s) return time_s.error();
  Result<std::string> file = ParseFileName(list, line.number, line.fields[first + 1]);
  if (!file) return file.error();
  return dataset::TimedFile{*time_s, *std::move(file), line.number};
}

double TimeOf(const dataset::TimedFile& file) { return file.time_s; }
double TimeOf(const dataset::ImagePair& pair) { return pair.depth.time_s; }
double TimeOf(const TimedPose& pose) { return pose.time_s; }

int LineOf(const dataset::TimedFile& file) { return file.line; }
int LineOf(const dataset::ImagePair& pair) { return pair.depth.line; }
int LineOf(const TimedPose& pose) { return pose.line; }

void SetClockSegment(dataset::TimedFile& file, int segment) { file.clock_segment = segment; }
void SetClockSegment(dataset::ImagePair& pair, int segment) {
  pair.colour.clock_segment = pair.depth.clock_segment = segment;
}
void SetClockSegment(TimedPose& pose, int segment) { pose.clock_segment = segment; }

// What an entry says, in an order.
auto Content(const dataset::TimedFile& file) { return std::tie(file.time_s, file.file); }
auto Content(const dataset::ImagePair& pair) {
  return std::tie(pair.depth.time_s, pair.colour.file, pair.depth.file);
}
auto Content(const TimedPose& pose) {
  const Eigen::Vector4d q = pose.world_from_camera.rotation.coeffs();
  const Eigen::Vector3d t = pose.world_from_camera.translation_m;
  return std::array{pose.time_s, q[0], q[1], q[2], q[3], t[0], t[1], t[2]};
}

// Lines written twice would look like a clock that was set back.
template <typename T>
void DropRepeatedLines(std::vector<T>& entries) {
  std::vector<std::size_t> order(entries.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto content = [&](std::size_t n) { return Content(entries[n]); };
  std::ranges::stable_sort(order, {}, content);
  std::vector<bool> repeats(entries.size(), false);
  for (std::size_t n = 1; n < order.size(); ++n)
    repeats[order[n]] = content(order[n]) == content(order[n - 1]);
  std::size_t k = 0;
  std::erase_if(entries, [&](const T&) { return repeats[k++]; });
}

template <typename T>
void NumberClockSegments(std::vector<T>& entries,
                         const std::filesystem::path& list,
                         std::vector<std::string>& warnings) {
  std::vector<double> times_s;
  for (const T& entry : entries) times_s.push_back(TimeOf(entry));
  const std::vector<int> segments = ClockSegments(times_s);
  for (std::size_t k = 0; k < entries.size(); ++k) SetClockSegment(entries[k], segments[k]);
  if (NumClockSegments(entries) <= 1) return;
  const auto fall = static_cast<std::size_t>(std::ranges::find(segments, 1) - segments.begin());
  const std::string others = segments.back() > 1
                                 ? fmt::format(", as at {} lines after it", segments.back() - 1)
                                 : std::string();
  warnings.push_back(
      fmt::format("{}:{}: the time falls back from {} to {} s{}: taken for a clock that was set "
                  "back, or recordings that were joined; the order of the file is kept there",
                  list.string(),
                  LineOf(entries[fall]),
                  times_s[fall - 1],
                  times_s[fall],
                  others));
}

// Lists of images whose lines mostly share their times have another column there.
Status CheckTimesDiffer(std::size_t num_lines,
                        std::size_t num_times,
                        const std::filesystem::path& list) {
  if (2 * num_times >= num_lines) return Ok();
  return InvalidInput(
      fmt::format("{}: {} different lines have {} times; the first column of each line has to be "
                  "the time of that image, in seconds",
                  list.string(),
                  num_lines,
                  num_times));
}

// Ascending in time and each time once, within each segment of the clock; says in `warnings` what
// that changed. The number of different lines there were.
template <typename T>
std::size_t SortByTime(std::vector<T>& entries,
                       const std::filesystem::path& list,
                       std::vector<std::string>& warnings) {
  const std::size_t count = entries.size();
  DropRepeatedLines(entries);
  const std::size_t num_lines = entries.size();
  NumberClockSegments(entries, list, warnings);
  const auto place = [](const T& entry) { return std::pair(ClockSegmentOf(entry), TimeOf(entry)); };
  if (!std::ranges::is_sorted(entries, {}, place)) {
    std::ranges::stable_sort(entries, {}, place);
    warnings.push_back(
        fmt::format("{}: times are not ascending; lines were sorted", list.string()));
  }
  const auto same_place = [&](const T& a, const T& b) { return place(a) == place(b); };
  entries.erase(std::unique(entries.begin(), entries.end(), same_place), entries.end());
  if (entries.size() < count) {
    warnings.push_back(fmt::format(
        "{}: {} lines repeat a time and were left out", list.string(), count - entries.size()));
  }
  return num_lines;
}

Error EmptyList(const std::filesystem::path& list) {
  return InvalidInput(fmt::format("{}: lists no images; a line reads 'time file'", list.string()));
}

// Of at least so many bytes each.
std::size_t MostLines(const std::string& text, std::size_t least_bytes) {
  const auto num_ends = static_cast<std::size_t>(std::ranges::count(text, '\n'));
  return std::min(num_ends, text.size() / least_bytes) + 1;
}

// Index of the entry nearest to a time in an ascending list (the earlier one when two are equally
// near).
std::size_t Nearest(std::span<const dataset::TimedFile> entries, double time_s) {
  const auto after = std::lower_bound(
      entries.begin(), entries.end(), time_s, [](const dataset::TimedFile& e, double t) {
        return e.time_s < t;
      });
  if (after == entries.begin()) return 0;
  const std::size_t next = static_cast<std::size_t>(after - entries.begin());
  if (next == entries.size()) return next - 1;
  return entries[next].time_s - time_s < time_s - entries[next - 1].time_s ? next : next - 1;
}

// Each line by `parse`: `Result<T>(const TextLine&)`. The last one is left out where the file ends
// within it and it cannot be understood.
template <typename T, typename Parse>
Result<std::vector<T>> ParseLines(const std::string& text,
                                  const std::filesystem::path& list,
                                  std::size_t least_bytes,
                                  const Parse& parse,
                                  std::vector<std::string>& warnings) {
  std::vector<T> entries;
  entries.reserve(MostLines(text, least_bytes));
  LineReader lines(text);
  while (const TextLine* const line = lines.Next()) {
    Result<T> entry = parse(*line);
    if (entry) {
      entries.push_back(*std::move(entry));
    } else if (!IsLeftOut(list, *line, warnings)) {
      return entry.error();
    }
  }
  return entries;
}

Result<dataset::ImagePair> ParseAssociation(const std::filesystem::path& list,
                                            const TextLine& line) {
  const Status count = CheckFieldCount(list, line, 4, "time rgb-file time depth-file");
  if (!count) return count.error();
  Result<dataset::TimedFile> first = ParseTimedFile(list, line, 0);
  if (!first) return first.error();
  Result<dataset::TimedFile> second = ParseTimedFile(list, line, 2);
  if (!second) return second.error();
  const auto is_depth = [](const dataset::TimedFile& f) {
    return f.file.find("depth") != std::string::npos;
  };
  if (is_depth(*first) && !is_depth(*second)) std::swap(first, second);
  return dataset::ImagePair{*std::move(first), *std::move(second)};
}

// Line 0: not tracked there.
Result<TimedPose> ParsePose(const std::filesystem::path& list, const TextLine& line) {
  // RTAB-Map writes the number of its node behind.
  const bool has_number = line.fields.size() == 9 && ParseNumber(line.fields[8]).has_value();
  if (!has_number) {
    const Status count = CheckFieldCount(list, line, 8, "time tx ty tz qx qy qz qw");
    if (!count) return count.error();
  }
  const Result<double> time_s = ParseTime(list, line.number, line.fields[0]);
  if (!time_s) return time_s.error();
  Eigen::Matrix<double, 7, 1> v;
  for (int i = 0; i < 7; ++i) {
    const std::string_view field = line.fields[static_cast<std::size_t>(i) + 1];
    const auto [end, code] = std::from_chars(field.data(), field.data() + field.size(), v[i]);
    if (code == std::errc() && end == field.data() + field.size()) continue;
    constexpr std::array<std::string_view, 7> kNames = {"tx", "ty", "tz", "qx", "qy", "qz", "qw"};
    return LineError(list,
                     line.number,
                     fmt::format("field '{}' is '{}', not a number: correct or remove the line",
                                 kNames[static_cast<std::size_t>(i)],
                                 Shown(field)));
  }
  const double norm = v.tail<4>().norm();
  if (!v.allFinite() || !(norm > 0.5 && norm < 2.0) ||
      v.head<3>().cwiseAbs().maxCoeff() > kMaxPositionM) {
    return TimedPose{*time_s, Pose3(), 0};
  }
  const Eigen::Quaterniond rotation(v[6] / norm, v[3] / norm, v[4] / norm, v[5] / norm);
  return TimedPose{*time_s, Pose3{rotation, v.head<3>()}, line.number};
}

}  // namespace

Result<std::vector<dataset::TimedFile>> ParseFileList(const std::string& text,
                                                      const std::filesystem::path& list,
                                                      std::vector<std::string>& warnings) {
  const auto parse = [&](const TextLine& line) -> Result<dataset::TimedFile> {
    const Status count = CheckFieldCount(list, line, 2, "time file");
    if (!count) return count.error();
    return ParseTimedFile(list, line, 0);
  };
  auto entries = ParseLines<dataset::TimedFile>(text, list, 4, parse, warnings);
  if (!entries) return entries;
  if (entries->empty()) return EmptyList(list);
  const std::size_t num_lines = SortByTime(*entries, list, warnings);
  if (Status status = CheckTimesDiffer(num_lines, entries->size(), list); !status.ok())
    return status.error();
  return entries;
}

Result<std::vector<dataset::ImagePair>> ParseAssociations(const std::string& text,
                                                          const std::filesystem::path& list,
                                                          std::vector<std::string>& warnings) {
  const auto parse = [&](const TextLine& line) { return ParseAssociation(list, line); };
  auto pairs = ParseLines<dataset::ImagePair>(text, list, 8, parse, warnings);
  if (!pairs) return pairs;
  if (pairs->empty()) return EmptyList(list);
  const std::size_t num_lines = SortByTime(*pairs, list, warnings);
  if (Status status = CheckTimesDiffer(num_lines, pairs->size(), list); !status.ok())
    return status.error();
  return pairs;
}

Result<std::vector<TimedPose>> ParsePoses(const std::string& text,
                                          const std::filesystem::path& list,
                                          std::vector<std::string>& warnings) {
  int first_unusable = 0;
  const auto parse = [&](const TextLine& line) {
    Result<TimedPose> pose = ParsePose(list, line);
    if (pose && pose->line == 0 && first_unusable == 0) first_unusable = line.number;
    return pose;
  };
  auto poses = ParseLines<TimedPose>(text, list, 16, parse, warnings);
  if (!poses) return poses;
  const std::size_t num_unusable =
      std::erase_if(*poses, [](const TimedPose& pose) { return pose.line == 0; });
  if (num_unusable > 0) {
    warnings.push_back(fmt::format(
        "{}:{}: {} poses are not finite or have no rotation and were left out, this one first",
        list.string(),
        first_unusable,
        num_unusable));
  }
  SortByTime(*poses, list, warnings);
  return poses;
}

std::vector<dataset::ImagePair> AssociateByTime(const std::vector<dataset::TimedFile>& all_colour,
                                                const std::vector<dataset::TimedFile>& all_depth,
                                                double tolerance_s) {
  std::vector<dataset::ImagePair> pairs;
  for (int number = 0; number < NumClockSegments(all_depth); ++number) {
    const std::span<const dataset::TimedFile> colour = ClockSegment(all_colour, number);
    const std::span<const dataset::TimedFile> depth = ClockSegment(all_depth, number);
    if (colour.empty()) continue;
    for (std::size_t d = 0; d < depth.size(); ++d) {
      const std::size_t c = Nearest(colour, depth[d].time_s);
      if (std::abs(colour[c].time_s - depth[d].time_s) > tolerance_s) continue;
      if (Nearest(depth, colour[c].time_s) == d) pairs.push_back({colour[c], depth[d]});
    }
  }
  return pairs;
}

std::optional<Pose3> PoseAt(std::span<const TimedPose> poses,
                            double time_s,
                            double tolerance_s,
                            double max_gap_s) {
  const auto after =
      std::lower_bound(poses.begin(), poses.end(), time_s, [](const TimedPose& p, double t) {
        return p.time_s < t;
      });
  if (after != poses.end() && after->time_s == time_s) return after->world_from_camera;
  const bool has_after = after != poses.end();
  const bool has_before = after != poses.begin();
  if (has_after && has_before) {
    const TimedPose& a = *(after - 1);
    const TimedPose& b = *after;
    if (b.time_s - a.time_s < max_gap_s) {
      const double share = (time_s - a.time_s) / (b.time_s - a.time_s);
      return Pose3{
          a.world_from_camera.rotation.slerp(share, b.world_from_camera.rotation).normalized(),
          (1 - share) * a.world_from_camera.translation_m +
              share * b.world_from_camera.translation_m};
    }
  }
  const TimedPose* nearest = nullptr;
  if (has_before) nearest = &*(after - 1);
  if (has_after && (nearest == nullptr || after->time_s - time_s < time_s - nearest->time_s))
    nearest = &*after;
  if (nearest == nullptr || std::abs(nearest->time_s - time_s) > tolerance_s) return std::nullopt;
  return nearest->world_from_camera;
}

}  // namespace deepslam::formats
