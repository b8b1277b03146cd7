// What cameras and people do to captures: the frames concerned say so, the others are right.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deepslam/core/random.h"
#include "tracking/tracked_sequence.h"

namespace deepslam::tracking {
namespace {

// Two seconds of frames that show nothing, in the midst of good ones.
struct Blackout {
  std::string name;
  std::function<void(Frame&)> spoil;
};

void PrintTo(const Blackout& blackout, std::ostream* out) { *out << blackout.name; }

void Darken(Frame& frame) { std::ranges::fill(frame.colour, Rgb8{4, 4, 4}); }

class EstimateOdometryBlackout : public ::testing::TestWithParam<Blackout> {};

TEST_P(EstimateOdometryBlackout, IsLostAndTheRestStaysRight) {
  const std::vector<Pose3> truth = Arc(64, 0.5);
  std::vector<Frame> frames = Render(BoxWorld::Furnished(), truth);
  for (std::size_t k = 12; k < 52; ++k) GetParam().spoil(frames[k]);
  const Odometry odometry = Track(std::move(frames));
  ExpectStatus(odometry, 0, 12, TrackingStatus::kTracked);
  ExpectStatus(odometry, 12, 52, TrackingStatus::kLost);
  ExpectStatus(odometry, 52, 64, TrackingStatus::kTracked);
  ExpectTrue(odometry, truth, 0, 12);
  for (std::size_t k = 52; k < 64; ++k) {
    EXPECT_THAT(odometry.frames[k].world_from_camera,
                PoseNear(truth[0].Inverse() * truth[k], 0.02, 0.6))
        << "frame " << k;
  }
  // In between the camera is taken to have gone straight on: good to the curvature of its path.
  ExpectTrue(odometry, truth, 0, 64, 0.04, 1.0);
  ExpectConsistent(odometry);
  ExpectHonestEdges(odometry, truth);
}

INSTANTIATE_TEST_SUITE_P(
    OfTwoSeconds,
    EstimateOdometryBlackout,
    ::testing::Values(
        Blackout{"NoDepth", [](Frame& frame) { std::ranges::fill(frame.depth_m, 0.0F); }},
        Blackout{"ConstantDepth", [](Frame& frame) { std::ranges::fill(frame.depth_m, 2.0F); }},
        // Of holes and a few strays as well.
        Blackout{"ConstantDepthWithHoles",
                 [](Frame& frame) {
                   std::ranges::fill(frame.depth_m, 2.0F);
                   for (int u = 40; u < 90; ++u) frame.depth_m(u, 60) = frame.depth_m(u, 61) = 0;
                   frame.depth_m(20, 20) = 1.2F;
                 }},
        Blackout{"ConstantDepthAndFrozenColour",
                 [](Frame& frame) {
                   std::ranges::fill(frame.depth_m, 2.0F);
                   frame.colour = RenderFrame(BoxWorld::Furnished(), Arc(1).front()).colour;
                 }},
        Blackout{"CoveredLens",
                 [](Frame& frame) {
                   std::ranges::fill(frame.depth_m, 0.0F);
                   Darken(frame);
                 }},
        Blackout{"CoveredLensAtOneDepth",
                 [](Frame& frame) {
                   std::ranges::fill(frame.depth_m, 0.3F);
                   Darken(frame);
                 }}),
    [](const auto& test) { return test.param.name; });

// A palm is a surface like others: what it shows is no place in the room, and is said to be weak.
TEST(EstimateOdometry, APalmBeforeTheCameraIsNotTrackedAsTheRoom) {
  const std::vector<Pose3> truth = Arc(64, 0.5);
  std::vector<Frame> frames = Render(BoxWorld::Furnished(), truth);
  Random random(1);
  for (std::size_t k = 12; k < 52; ++k) {
    for (float& z : frames[k].depth_m) z = static_cast<float>(0.3 + 0.0012 * random.Normal());
    Darken(frames[k]);
  }
  const Odometry odometry = Track(std::move(frames));
  ExpectStatus(odometry, 0, 12, TrackingStatus::kTracked);
  for (std::size_t k = 12; k < 52; ++k)
    EXPECT_NE(odometry.frames[k].status, TrackingStatus::kTracked) << "frame " << k;
  ExpectStatus(odometry, 52, 64, TrackingStatus::kTracked);
  for (const std::size_t k : {11U, 52U, 63U}) {
    EXPECT_THAT(odometry.frames[k].world_from_camera,
                PoseNear(truth[0].Inverse() * truth[k], 0.02, 0.6));
  }
  ExpectConsistent(odometry);
}

TEST(EstimateOdometry, BeginsAtTheFirstFrameOfMoreThanOneDepth) {
  const std::vector<Pose3> truth = Arc(20);
  std::vector<Frame> frames = Render(BoxWorld::Furnished(), truth);
  for (std::size_t k = 0; k < 9; ++k) std::ranges::fill(frames[k].depth_m, 1.7F);
  frames[3] = Frame{};
  const Odometry odometry = Track(std::move(frames));
  for (std::size_t k = 0; k < 9; ++k) {
    EXPECT_EQ(odometry.frames[k].status,
              k == 3 ? TrackingStatus::kUnreadable : TrackingStatus::kLost);
  }
  ExpectStatus(odometry, 9, 20, TrackingStatus::kTracked);
  EXPECT_EQ(odometry.keyframes.front(), FrameIdx{9});
  EXPECT_EQ(odometry.frames[9].world_from_camera, Pose3{});
  ExpectTrue(odometry, truth, 9, 20);
  ExpectConsistent(odometry);
  ExpectHonestEdges(odometry, truth);
}

// Nothing better ever comes: a wall, perhaps, and said to be weak.
TEST(EstimateOdometry, OneDepthThroughoutIsWeaklyConstrained) {
  std::vector<Frame> frames = Render(BoxWorld::Furnished(), Arc(6));
  for (Frame& frame : frames) std::ranges::fill(frame.depth_m, 2.0F);
  const Odometry odometry = Track(std::move(frames));
  ExpectStatus(odometry, 0, 6, TrackingStatus::kDegenerate);
}

// A bare hall: the camera goes along one wall, from one end of it to the other.
struct AlongAWall {
  BoxWorld hall;
  std::vector<Pose3> truth;
  std::size_t bare_begin = 0;  // the first frame that sees no more than wall and floor ...
  std::size_t bare_end = 0;    // ... and behind the last
};

AlongAWall GoAlongAWall(double texture) {
  AlongAWall walk;
  walk.hall.room = {{-1.0, -20, 0}, {5.0, 2.6, 20}};
  walk.hall.texture = texture;
  // Half the view's width where it meets the wall, some more for the floor.
  const double half_width_m = 1.8;
  for (double x = -0.2; x < 4.2;) {
    walk.truth.push_back(LookAt({x, 0, 1.5}, {x, 2.6, 0.9}));
    const bool bare =
        x - half_width_m > walk.hall.room.min.x() && x + half_width_m < walk.hall.room.max.x();
    if (bare && walk.bare_begin == 0) walk.bare_begin = walk.truth.size() - 1;
    if (bare) walk.bare_end = walk.truth.size();
    // Its pace changes where nothing shows it.
    x += x > 1.6 && x < 2.4 ? 0.03 : 0.04;
  }
  return walk;
}

TEST(EstimateOdometry, AlongABareWallFramesSayThatTheyMaySlide) {
  const AlongAWall walk = GoAlongAWall(0.0);
  ASSERT_GT(walk.bare_end, walk.bare_begin + 20);
  const Odometry odometry = Track(Render(walk.hall, walk.truth));
  // An end of the hall shows where the camera is as soon as enough of it is in view.
  ExpectStatus(odometry, 0, walk.bare_begin - 5, TrackingStatus::kTracked);
  for (std::size_t k = walk.bare_begin; k < walk.bare_end; ++k)
    EXPECT_NE(odometry.frames[k].status, TrackingStatus::kTracked) << "frame " << k;
  ExpectStatus(odometry, walk.bare_end + 8, walk.truth.size(), TrackingStatus::kTracked);
  ExpectTrue(odometry, walk.truth, 0, walk.bare_begin - 5);
  // Behind the bare wall the sub-trajectories fit in themselves.
  ExpectTrue(odometry, walk.truth, walk.bare_end + 8, walk.truth.size());
  ExpectConsistent(odometry);
  ExpectHonestEdges(odometry, walk.truth);
  // What the wall shows is right all along: its distance, and that the camera does not turn.
  for (std::size_t k = walk.bare_begin; k < walk.bare_end; ++k) {
    const Pose3 error =
        (walk.truth[0].Inverse() * walk.truth[k]).Inverse() * odometry.frames[k].world_from_camera;
    EXPECT_LT(std::abs(error.translation_m.z()), 0.03) << "frame " << k;
    EXPECT_LT(RotationAngle(error.rotation), 1.0 * kRadPerDeg) << "frame " << k;
  }
}

// It begins before the bare wall, so that nothing has shown its motion until the end comes in view.
TEST(EstimateOdometry, AMotionThatNothingShowsIsBoundedLooselyAndEndsWhereSomethingIsSeen) {
  AlongAWall walk = GoAlongAWall(0.0);
  const auto first_bare = walk.truth.begin() + static_cast<std::ptrdiff_t>(walk.bare_begin);
  walk.truth.erase(walk.truth.begin(), first_bare);
  walk.bare_end -= walk.bare_begin;
  const Odometry odometry = Track(Render(walk.hall, walk.truth));
  ExpectStatus(odometry, 1, walk.bare_end, TrackingStatus::kDegenerate);
  // The end of the hall is of use as soon as a keyframe has it, half a second later.
  const std::size_t seen = walk.bare_end + 12;
  ExpectStatus(odometry, seen, walk.truth.size(), TrackingStatus::kTracked);
  ExpectTrue(odometry, walk.truth, seen, walk.truth.size());
  ExpectConsistent(odometry);
  ExpectHonestEdges(odometry, walk.truth);
}

TEST(EstimateOdometry, AlongAWallThatImagesSeeNothingSlides) {
  const AlongAWall walk = GoAlongAWall(1.0);
  const Odometry odometry = Track(Render(walk.hall, walk.truth));
  // Where a change of pace is less than what images surely show, a frame says so.
  const auto tracked = std::ranges::count(
      odometry.frames, TrackingStatus::kTracked, [](const auto& frame) { return frame.status; });
  EXPECT_GE(tracked, 0.95 * static_cast<double>(walk.truth.size()));
  ExpectTrue(odometry, walk.truth, 0, walk.truth.size(), 0.03, 0.8);
  ExpectHonestEdges(odometry, walk.truth);
}

// Turns away to a wall for a while without passing over what lies between, then is back at the
// start.
std::vector<Pose3> ThereAndBack() {
  std::vector<Pose3> truth = Arc(6, 1.0);
  for (int k = 0; k < 14; ++k)
    truth.push_back(LookAt({0.2 + 0.03 * k, 1.5, 1.2}, {-0.6 + 0.03 * k, -0.6, 0.5}));
  for (int k = 0; k < 6; ++k) truth.push_back(Arc(6, 1.0)[static_cast<std::size_t>(5 - k)]);
  return truth;
}

TEST(EstimateOdometry, ATeleportIsALostFrameAndWhatLiesBetweenIsRightInItself) {
  const std::vector<Pose3> truth = ThereAndBack();
  const Odometry odometry = Track(Render(BoxWorld::Furnished(), truth));
  for (std::size_t k = 0; k < truth.size(); ++k) {
    EXPECT_EQ(odometry.frames[k].status, k == 6 ? TrackingStatus::kLost : TrackingStatus::kTracked)
        << "frame " << k;
  }
  ExpectTrue(odometry, truth, 0, 6);
  ExpectTrue(odometry, truth, 6, 20);
  // Back at the start, frames are placed against the first ones.
  for (std::size_t k = 20; k < truth.size(); ++k) {
    EXPECT_THAT(odometry.frames[k].world_from_camera,
                PoseNear(truth[0].Inverse() * truth[k], 0.02, 0.6))
        << "frame " << k;
  }
  // Nothing but weak edges joins what was not seen together.
  for (const RelativePose& edge : odometry.edges) {
    const auto away = [](FrameIdx frame) { return frame.value >= 6 && frame.value < 20; };
    EXPECT_EQ(edge.composed, away(edge.i) != away(edge.j)) << edge.i << " to " << edge.j;
  }
  ExpectHonestEdges(odometry, truth);
  ExpectConsistent(odometry);
}

TEST(EstimateOdometry, ASubTrajectoryAfterATeleportIsCarriedOverWhenItSeesAnEarlierKeyframe) {
  // From the other side of the room it comes back to the start all the way.
  std::vector<Pose3> truth = Arc(6, 1.0);
  const std::vector<Pose3> round = Arc(45, 4.0);
  for (std::size_t k = 0; k < 23; ++k) truth.push_back(round[24 - k]);
  const Odometry odometry = Track(Render(BoxWorld::Furnished(), truth));
  for (std::size_t k = 0; k < truth.size(); ++k) {
    EXPECT_EQ(odometry.frames[k].status, k == 6 ? TrackingStatus::kLost : TrackingStatus::kTracked)
        << "frame " << k;
  }
  ExpectTrue(odometry, truth, 0, truth.size(), 0.03, 0.8);
  ExpectConsistent(odometry);
}

// The clock of a capture is set back twice while the camera goes on: once where nothing is seen.
TEST(EstimateOdometry, AClockThatIsSetBackChangesNothingButTheTimes) {
  const std::vector<Pose3> truth = Arc(30);
  std::vector<Frame> frames = Render(BoxWorld::Furnished(), truth);
  for (std::size_t k = 12; k < 18; ++k) std::ranges::fill(frames[k].depth_m, 0.0F);
  for (std::size_t k = 17; k < frames.size(); ++k) frames[k].time_s += 0.3;
  const Odometry straight = Track(frames);
  for (std::size_t k = 15; k < frames.size(); ++k) frames[k].time_s -= 0.55;
  for (std::size_t k = 23; k < frames.size(); ++k) frames[k].time_s -= 0.22;
  const Odometry set_back = Track(frames);
  for (std::size_t k = 0; k < truth.size(); ++k) {
    EXPECT_EQ(set_back.frames[k].time_s, frames[k].time_s);
    EXPECT_EQ(set_back.frames[k].status, straight.frames[k].status) << "frame " << k;
    EXPECT_THAT(set_back.frames[k].world_from_camera,
                PoseNear(straight.frames[k].world_from_camera, 1e-9, 1e-5))
        << "frame " << k;
  }
  EXPECT_EQ(set_back.keyframes, straight.keyframes);
  ExpectTrue(set_back, truth, 0, 12);
  ExpectTrue(set_back, truth, 18, truth.size());
}

// Two places, and the clock of the second overlaps that of the first.
TEST(EstimateOdometry, RecordingsWhoseClocksOverlapAreRightInThemselves) {
  const std::vector<Pose3> truth = ThereAndBack();
  std::vector<Frame> frames = Render(BoxWorld::Furnished(), truth);
  for (std::size_t k = 6; k < frames.size(); ++k) frames[k].time_s -= 0.22;
  const Odometry odometry = Track(std::move(frames));
  for (std::size_t k = 0; k < truth.size(); ++k) {
    EXPECT_EQ(odometry.frames[k].status, k == 6 ? TrackingStatus::kLost : TrackingStatus::kTracked)
        << "frame " << k;
  }
  ExpectTrue(odometry, truth, 0, 6);
  ExpectTrue(odometry, truth, 6, 20);
  ExpectTrue(odometry, truth, 20, truth.size());
  ExpectHonestEdges(odometry, truth);
}

}  // namespace
}  // namespace deepslam::tracking
