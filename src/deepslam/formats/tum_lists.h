// The text files of the TUM RGB-D layout, as values.
//
// Fields are separated by blanks, tabs or commas; lines that are empty or begin with '#' carry
// nothing. A line that cannot be understood is an error naming file, line and field, but for one
// that the file ends within: it is left out with a warning. Times out of
// order are sorted, repeated times dropped (the first stays); both are said in `warnings`. Where
// the clock was set back (core/clock_segments.h), or recordings were joined, the order of the file
// stays: times ascend within a segment, and the same times may stand in several. That is said too,
// with the line.
#pragma once

#include <algorithm>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/dataset/image_pair.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::formats {

struct TimedPose {
  double time_s = 0;
  Pose3 world_from_camera;
  int line = 0;
  int clock_segment = 0;
};

// rgb.txt, depth.txt: `time file`.
Result<std::vector<dataset::TimedFile>> ParseFileList(const std::string& text,
                                                      const std::filesystem::path& list,
                                                      std::vector<std::string>& warnings);

// associations.txt: `time file time file`, colour first; written the other way round when the file
// names say so
// ("depth" in the first and not in the second).
Result<std::vector<dataset::ImagePair>> ParseAssociations(const std::string& text,
                                                          const std::filesystem::path& list,
                                                          std::vector<std::string>& warnings);

// groundtruth.txt: `time tx ty tz qx qy qz qw`, also with a number of a node behind. Lines with
// values that are not finite, or without a rotation, mean "not tracked here": they are left out
// with a warning. May be empty.
Result<std::vector<TimedPose>> ParsePoses(const std::string& text,
                                          const std::filesystem::path& list,
                                          std::vector<std::string>& warnings);

inline int ClockSegmentOf(const TimedPose& pose) { return pose.clock_segment; }

template <typename T>
int NumClockSegments(const std::vector<T>& entries) {
  return entries.empty() ? 0 : ClockSegmentOf(entries.back()) + 1;
}

// The entries of one segment; empty where there is none of the number.
template <typename T>
std::span<const T> ClockSegment(const std::vector<T>& entries, int number) {
  const auto segment = [](const T& entry) { return ClockSegmentOf(entry); };
  return {std::ranges::lower_bound(entries, number, {}, segment),
          std::ranges::upper_bound(entries, number, {}, segment)};
}

// Pairs of images that are each other's nearest in time and at most `tolerance_s` apart, of
// segments with the same number; both lists as parsed.
std::vector<dataset::ImagePair> AssociateByTime(const std::vector<dataset::TimedFile>& colour,
                                                const std::vector<dataset::TimedFile>& depth,
                                                double tolerance_s);

// The pose at a time: between two poses less than `max_gap_s` apart by interpolation (slerp), else
// the nearest one if within `tolerance_s`, else nothing. `poses` ascending, of one segment.
std::optional<Pose3> PoseAt(std::span<const TimedPose> poses,
                            double time_s,
                            double tolerance_s,
                            double max_gap_s);

}  // namespace deepslam::formats
