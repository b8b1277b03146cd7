#include "deepslam/core/clock_segments.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "deepslam/core/order_statistics.h"

namespace deepslam {
namespace {

// Entries that fill gaps leave the usual interval between them, those of a second segment at the
// same rate half of it.
constexpr double kFillsGaps = 0.75;
// What belongs to the same segment has a neighbour this near, in usual intervals.
constexpr double kNearIntervals = 2;

using Times = std::vector<double>;

double UsualInterval(std::span<const double> times_s) {
  std::vector<double> intervals;
  for (std::size_t k = 1; k < times_s.size(); ++k) {
    if (times_s[k] != times_s[k - 1]) intervals.push_back(std::abs(times_s[k] - times_s[k - 1]));
  }
  return Median(intervals);
}

// Whether a run of ascending times belongs among those of a segment, ascending as well, behind
// whose end it began.
bool FillsGaps(const Times& segment, std::span<const double> run, double interval_s) {
  double nearest_s = std::numeric_limits<double>::infinity();
  double gaps_s = 0;
  double num_intervals = 0;
  for (std::size_t k = 0; k < run.size();) {
    const auto after = std::lower_bound(segment.begin(), segment.end(), run[k]);
    if (after == segment.end()) {
      nearest_s = std::min(nearest_s, run[k] - segment.back());
      break;
    }
    nearest_s = std::min(nearest_s, *after - run[k]);
    // All of the run that lies before `after`, or on it.
    std::size_t end = k;
    while (end < run.size() && run[end] <= *after) ++end;
    if (after != segment.begin()) {
      nearest_s = std::min(nearest_s, run[k] - *(after - 1));
      gaps_s += *after - *(after - 1);
      num_intervals += static_cast<double>(end - k + 1);
    }
    nearest_s = std::min(nearest_s, *after - run[end - 1]);
    k = end;
  }
  return gaps_s >= kFillsGaps * interval_s * num_intervals &&
         nearest_s <= kNearIntervals * interval_s;
}

void Merge(std::span<const double> run, Times& segment) {
  const auto from = std::lower_bound(segment.begin(), segment.end(), run.front());
  const auto begin = from - segment.begin();
  const auto middle = static_cast<std::ptrdiff_t>(segment.size());
  segment.insert(segment.end(), run.begin(), run.end());
  std::inplace_merge(segment.begin() + begin, segment.begin() + middle, segment.end());
}

std::size_t EndOfRun(std::span<const double> times_s, std::size_t begin) {
  std::size_t end = begin + 1;
  while (end < times_s.size() && times_s[end] >= times_s[end - 1]) ++end;
  return end;
}

}  // namespace

std::vector<int> ClockSegments(std::span<const double> times_s) {
  std::vector<int> segments(times_s.size(), 0);
  std::size_t num_falls = 0;
  for (std::size_t k = 1; k < times_s.size(); ++k) num_falls += times_s[k] < times_s[k - 1] ? 1 : 0;
  if (num_falls == 0 || 4 * num_falls > times_s.size() - 1) return segments;
  const double interval_s = UsualInterval(times_s);
  Times segment;
  int number = 0;
  for (std::size_t begin = 0; begin < times_s.size();) {
    const std::size_t end = EndOfRun(times_s, begin);
    const auto run = times_s.subspan(begin, end - begin);
    if (!segment.empty() && run.front() < segment.back() && !FillsGaps(segment, run, interval_s)) {
      ++number;
      segment.clear();
    }
    Merge(run, segment);
    std::fill(segments.begin() + static_cast<std::ptrdiff_t>(begin),
              segments.begin() + static_cast<std::ptrdiff_t>(end),
              number);
    begin = end;
  }
  return segments;
}

}  // namespace deepslam
