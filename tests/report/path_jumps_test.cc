// Paths of several kinds of cameras, with and without a jump.
#include "deepslam/report/path_jumps.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include <gmock/gmock.h>

#include "deepslam/core/angles.h"
#include "deepslam/core/random.h"

namespace deepslam::report {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// A step of a camera: so far ahead, and turned so far to the side.
struct Stride {
  double ahead_m = 0;
  double turn_deg = 0;
};

std::vector<TrackedFrame> PathOf(const std::vector<Stride>& strides, double interval_s) {
  std::vector<TrackedFrame> frames(1);
  for (const Stride& stride : strides) {
    const Pose3 moved{RotationFromVector({0, stride.turn_deg * kRadPerDeg, 0}),
                      {0, 0, stride.ahead_m}};
    TrackedFrame frame = frames.back();
    frame.frame = FrameIdx{frame.frame.value + 1};
    frame.time_s += interval_s;
    frame.world_from_camera = frames.back().world_from_camera * moved;
    frames.push_back(frame);
  }
  return frames;
}

std::vector<std::size_t> JumpsOf(const std::vector<Stride>& strides, double interval_s) {
  std::vector<std::size_t> to_frames;
  for (const PathJump& jump : FindPathJumps(PathOf(strides, interval_s)))
    to_frames.push_back(jump.to_frame);
  return to_frames;
}

// A frame per key press, with what tracking errs by: a quarter of a metre, or ten degrees.
std::vector<Stride> KeyPresses(int count, double share_of_turns, std::uint64_t seed) {
  Random random(seed, "keys", 0);
  std::vector<Stride> strides;
  for (int k = 0; k < count; ++k) {
    const bool turns = random.Uniform() < share_of_turns;
    strides.push_back(
        {(turns ? 0 : 0.25) + 0.004 * random.Normal(), (turns ? 10 : 0) + 0.1 * random.Normal()});
  }
  return strides;
}

// A hand at 30 frames a second whose pace and turning swell and fade within seconds.
std::vector<Stride> Hand(int count, double scale, std::uint64_t seed) {
  Random random(seed, "hand", 0);
  const double phase = 6 * random.Uniform();
  std::vector<Stride> strides;
  for (int k = 0; k < count; ++k) {
    const double pace = std::pow(std::sin(phase + k / 40.0), 2);
    const double turning = std::sin(phase + k / 27.0);
    strides.push_back({scale * (0.015 * pace + 0.001 * random.Normal()),
                       scale * (1.2 * turning + 0.05 * random.Normal())});
  }
  return strides;
}

TEST(FindPathJumps, StepsOfAFramePerKeyPressAreNone) {
  for (const double share_of_turns : {0.1, 0.3, 0.5, 0.7, 0.9}) {
    for (const std::uint64_t seed : {1U, 2U, 3U})
      EXPECT_THAT(JumpsOf(KeyPresses(240, share_of_turns, seed), 0.1), IsEmpty())
          << share_of_turns << ' ' << seed;
  }
  EXPECT_THAT(JumpsOf(KeyPresses(20, 0.5, 1), 0.1), IsEmpty());
}

TEST(FindPathJumps, SparseFramesOfAHandAreNone) {
  for (const double scale : {1.0, 5.0, 20.0, 40.0}) {
    for (const std::uint64_t seed : {1U, 2U, 3U})
      EXPECT_THAT(JumpsOf(Hand(300, scale, seed), scale / 30), IsEmpty()) << scale << ' ' << seed;
  }
}

TEST(FindPathJumps, AStepFarBeyondASteadyPaceIsOne) {
  std::vector<Stride> strides = Hand(300, 1, 1);
  strides[120].ahead_m += 0.5;
  EXPECT_THAT(JumpsOf(strides, 1 / 30.0), ElementsAre(121));
  strides[120].ahead_m -= 0.5;
  strides[180].turn_deg += 40;
  const std::vector<PathJump> turned = FindPathJumps(PathOf(strides, 1 / 30.0));
  ASSERT_EQ(turned.size(), 1U);
  EXPECT_EQ(turned[0].to_frame, 181U);
  EXPECT_TRUE(turned[0].is_turn);
  EXPECT_NEAR(turned[0].angle_rad, 40 * kRadPerDeg, 2 * kRadPerDeg);
}

// Neither is beyond everything the capture does: as long as two of its strides, on a turn.
TEST(FindPathJumps, AStepThatNoTurnOfTheCaptureMakesIsOne) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    std::vector<Stride> strides = KeyPresses(240, 0.6, seed);
    const auto turn = std::find_if(strides.begin() + 100, strides.end(), [](const Stride& stride) {
      return stride.turn_deg > 5;
    });
    turn->ahead_m = 0.35;
    EXPECT_THAT(JumpsOf(strides, 0.1),
                ElementsAre(static_cast<std::size_t>(std::distance(strides.begin(), turn)) + 1));
  }
}

TEST(FindPathJumps, OnATurnOnTheSpotAShortCaptureTellsAsWell) {
  std::vector<Stride> strides(22, Stride{0.004, 12});
  EXPECT_THAT(JumpsOf(strides, 0.1), IsEmpty());
  strides[15].ahead_m = 0.35;
  EXPECT_THAT(JumpsOf(strides, 0.1), ElementsAre(16));
}

TEST(FindPathJumps, ManyOfOneCaptureAreAllFound) {
  std::vector<Stride> strides = Hand(400, 1, 2);
  for (const std::size_t k : {50U, 120U, 121U, 200U, 333U}) strides[k].ahead_m += 0.6;
  EXPECT_THAT(JumpsOf(strides, 1 / 30.0), ElementsAre(51, 121, 122, 201, 334));
}

TEST(FindPathJumps, FramesThatAreLeftOutMakeNone) {
  std::vector<TrackedFrame> frames = PathOf(Hand(300, 1, 3), 1 / 30.0);
  for (std::size_t k = 100; k < 130; ++k) frames[k].status = TrackingStatus::kLost;
  EXPECT_THAT(FindPathJumps(frames), IsEmpty());
  frames.erase(frames.begin() + 100, frames.begin() + 130);
  EXPECT_THAT(FindPathJumps(frames), IsEmpty());
}

TEST(FindPathJumps, OfHardlyAnyFramesNothingIsSaid) {
  EXPECT_THAT(FindPathJumps({}), IsEmpty());
  for (const int count : {0, 1, 2})
    EXPECT_THAT(JumpsOf(std::vector<Stride>(static_cast<std::size_t>(count), {0.01, 1}), 0.1),
                IsEmpty());
  // Times that stand still, or are not ordered, are none.
  std::vector<TrackedFrame> still = PathOf(Hand(30, 1, 1), 0);
  EXPECT_THAT(FindPathJumps(still), IsEmpty());
}

}  // namespace
}  // namespace deepslam::report
