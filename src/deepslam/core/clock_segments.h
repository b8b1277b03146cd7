// Times that jump back: where a recorder's clock was set back, or recordings were joined.
#pragma once

#include <span>
#include <vector>

namespace deepslam {

// Which segment of its clock each of the times, finite and in the order they were written in,
// belongs to: 0, ..., 0, 1, ..., 1, ... A segment begins where the time falls back to where
// entries stand already, or to far from any. All 0 where putting in order is all that is needed:
// times that are out of place among each other (written late, or sorted as names) fall into gaps;
// and where more than a quarter of the steps falls (a reversed or shuffled list), the order says
// nothing about the recording. Within a segment times may be out of order.
[[nodiscard]] std::vector<int> ClockSegments(std::span<const double> times_s);

}  // namespace deepslam
