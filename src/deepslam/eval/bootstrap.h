// How sure a mean is that rests on few objects.
#pragma once

#include <cstdint>
#include <span>

namespace deepslam::eval {

struct Interval {
  double mean = 0;
  double low = 0;   // 2.5 % of the resampled means
  double high = 0;  // 97.5 %
};

// Percentile bootstrap of the mean, 10,000 resamples. Of the differences of paired values it is the
// paired bootstrap. All zero for an empty list; a single value is its own interval.
[[nodiscard]] Interval BootstrapMean(std::span<const double> values, std::uint64_t seed);

}  // namespace deepslam::eval
