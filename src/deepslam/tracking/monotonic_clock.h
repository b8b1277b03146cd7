// The clock of a capture, going on where it was set back.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "deepslam/core/ids.h"

namespace deepslam::tracking {

// Where a time falls behind the one before, one more interval is taken to have passed, as long as
// the last one, and what follows is that much ahead of the capture.
class MonotonicClock {
 public:
  // The next frame's time on this clock, from that of the capture; never falls.
  double Advance(double time_s);

  // Of all frames so far.
  [[nodiscard]] std::span<const double> times_s() const { return times_s_; }
  [[nodiscard]] double TimeOf(FrameIdx frame) const {
    return times_s_[static_cast<std::size_t>(frame.value)];
  }

 private:
  double behind_s_ = 0;  // of the capture, by what it was set back
  std::vector<double> times_s_;
};

}  // namespace deepslam::tracking
