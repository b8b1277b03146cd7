#include "deepslam/tracking/monotonic_clock.h"

namespace deepslam::tracking {

double MonotonicClock::Advance(double time_s) {
  double clock_s = time_s + behind_s_;
  if (!times_s_.empty() && !(clock_s >= times_s_.back())) {
    const std::size_t last = times_s_.size() - 1;
    const double interval_s = last > 0 ? times_s_[last] - times_s_[last - 1] : 0;
    const double goes_on_s = times_s_[last] + interval_s;
    behind_s_ += goes_on_s - clock_s;
    clock_s = goes_on_s;
  }
  times_s_.push_back(clock_s);
  return clock_s;
}

}  // namespace deepslam::tracking
