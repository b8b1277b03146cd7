#include "deepslam/tracking/monotonic_clock.h"

#include <vector>

#include <gtest/gtest.h>

namespace deepslam::tracking {
namespace {

std::vector<double> ClockOf(const std::vector<double>& times_s) {
  MonotonicClock clock;
  for (const double time_s : times_s) clock.Advance(time_s);
  return {clock.times_s().begin(), clock.times_s().end()};
}

TEST(MonotonicClock, IsTheCapturesWhereThatGoesOn) {
  const std::vector<double> times_s = {3.0, 3.05, 3.05, 3.2, 90.0};
  EXPECT_EQ(ClockOf(times_s), times_s);
}

TEST(MonotonicClock, GoesOnByOneIntervalWhereTheCapturesIsSetBack) {
  const std::vector<double> clock_s = ClockOf({10.0, 10.5, 2.0, 2.5, 3.5});
  const std::vector<double> expected_s = {10.0, 10.5, 11.0, 11.5, 12.5};
  ASSERT_EQ(clock_s.size(), expected_s.size());
  for (std::size_t k = 0; k < clock_s.size(); ++k) EXPECT_NEAR(clock_s[k], expected_s[k], 1e-12);
}

TEST(MonotonicClock, StandsStillWhereNoIntervalIsKnown) {
  EXPECT_EQ(ClockOf({10.0, 2.0}), (std::vector<double>{10.0, 10.0}));
}

// However often: it never falls, and keeps all intervals that do not.
TEST(MonotonicClock, NeverFallsAndKeepsIntervals) {
  const std::vector<double> times_s = {5, 5.5, 1, 1.25, 0.5, 0.5, 7, -3, -2};
  const std::vector<double> clock_s = ClockOf(times_s);
  for (std::size_t k = 1; k < clock_s.size(); ++k) {
    EXPECT_GE(clock_s[k], clock_s[k - 1]) << k;
    const double interval_s = times_s[k] - times_s[k - 1];
    if (interval_s >= 0) {
      EXPECT_NEAR(clock_s[k] - clock_s[k - 1], interval_s, 1e-12) << k;
    }
  }
}

}  // namespace
}  // namespace deepslam::tracking
