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

void ExpectStatus(const Odometry& odometry,
                  std::size_t begin,
                  std::size_t end,
                  TrackingStatus status) {
  for (std::size_t k = begin; k < end; ++k)
    EXPECT_EQ(odometry.frames[k].status, status) << "frame " << k;
}

// Every edge that claims to be measured is as good as it claims.
void ExpectHonestEdges(const Odometry& odometry, const std::vector<Pose3>& truth) {
  for (const RelativePose& edge : odometry.edges) {
    if (edge.composed) continue;
    const Pose3 true_i_from_j = truth[static_cast<std::size_t>(edge.i.value)].Inverse() *
                                truth[static_cast<std::size_t>(edge.j.value)];
    const Vector6d error = T2v(edge.i_from_j.Inverse() * true_i_from_j);
    // Five standard deviations.
    EXPECT_LT(error.dot(edge.information.Full() * error), 25) << edge.i << " to " << edge.j;
  }
}

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

// A person: legs, trunk and head, standing on the floor at the origin.
std::vector<Box3> Person() {
  return {{{-0.20, -0.10, 0.0}, {-0.05, 0.10, 0.8}},
          {{0.05, -0.10, 0.0}, {0.20, 0.10, 0.8}},
          {{-0.25, -0.15, 0.8}, {0.25, 0.15, 1.5}},
          {{-0.10, -0.10, 1.5}, {0.10, 0.10, 1.75}}};
}

double ShareOfWalker(const BoxWorld& world, const Pose3& world_from_camera) {
  int count = 0;
  for (int v = 0; v < kSmallCamera.height; ++v) {
    for (int u = 0; u < kSmallCamera.width; ++u) {
      const Eigen::Vector3d ray = world_from_camera.rotation * kSmallCamera.Ray(u, v);
      const double walker = world.CastWalker(world_from_camera.translation_m, ray);
      count += walker <= world.Cast(world_from_camera.translation_m, ray) ? 1 : 0;
    }
  }
  return static_cast<double>(count) / (kSmallCamera.width * kSmallCamera.height);
}

struct Walk {
  std::string name;
  double camera_step_deg;  // of the camera, per frame
  double pace_m;           // of the person, per frame: to the right where positive
  double distance_m;       // of the person from the camera in the middle
  double covered_share;    // of the view, at least, when most is
};

void PrintTo(const Walk& walk, std::ostream* out) { *out << walk.name; }

struct WalkPast {
  std::vector<Pose3> truth;
  std::vector<Frame> frames;
  double largest_share = 0;
  int num_seen = 0;  // frames in which the person is
};

WalkPast RenderWalkPast(const Walk& walk) {
  constexpr int kNumFrames = 70;
  WalkPast past;
  past.truth = Arc(kNumFrames, walk.camera_step_deg);
  const Pose3& middle = past.truth[kNumFrames / 2];
  BoxWorld world = BoxWorld::Furnished();
  world.walker = Person();
  for (std::size_t k = 0; k < past.truth.size(); ++k) {
    const double aside_m = walk.pace_m * (static_cast<double>(k) - kNumFrames / 2);
    world.walked_m = middle * Eigen::Vector3d(aside_m, 0, walk.distance_m);
    world.walked_m.z() = 0;
    const double share = ShareOfWalker(world, past.truth[k]);
    past.largest_share = std::max(past.largest_share, share);
    past.num_seen += share > 0 ? 1 : 0;
    past.frames.push_back(RenderFrame(world, past.truth[k], 1.0, k));
    past.frames.back().time_s = 0.05 * static_cast<double>(k);
  }
  return past;
}

class EstimateOdometryWalker : public ::testing::TestWithParam<Walk> {};

// Someone walks by and covers a third of the view, more than half, two thirds.
TEST_P(EstimateOdometryWalker, DoesNotTakeTheCameraAlong) {
  const WalkPast walk = RenderWalkPast(GetParam());
  const std::size_t num_frames = walk.frames.size();
  ASSERT_GT(walk.largest_share, GetParam().covered_share);
  ASSERT_GE(walk.num_seen, 20);  // a second
  ASSERT_LT(walk.num_seen, static_cast<int>(num_frames) - 15);
  const Odometry odometry = Track(walk.frames);
  ExpectStatus(odometry, 0, num_frames, TrackingStatus::kTracked);
  // The person's step is 6 cm.
  ExpectTrue(odometry, walk.truth, 0, num_frames, 0.02, 0.6);
  ExpectConsistent(odometry);
  ExpectHonestEdges(odometry, walk.truth);
}

INSTANTIATE_TEST_SUITE_P(
    Passes,
    EstimateOdometryWalker,
    ::testing::Values(Walk{"AStandingCamera", 0.0, 0.06, 1.2, 0.30},
                      Walk{"AMovingCamera", 0.5, 0.06, 1.2, 0.30},
                      Walk{"AMovingCameraTheOtherWay", 0.5, -0.06, 1.2, 0.30},
                      Walk{"AFastCamera", 1.0, 0.06, 1.2, 0.30},
                      Walk{"AStandingCameraNearBy", 0.0, 0.06, 0.8, 0.50},
                      Walk{"AMovingCameraNearBy", 0.5, 0.06, 0.8, 0.50},
                      Walk{"AMovingCameraTheOtherWayNearBy", 0.5, -0.06, 0.8, 0.50},
                      Walk{"AFastCameraNearBy", 1.0, 0.06, 0.8, 0.50},
                      Walk{"AStandingCameraNearer", 0.0, 0.06, 0.65, 0.60}),
    [](const auto& test) { return test.param.name; });

// What can be told of the camera while next to nothing but a passer-by is in view is that it is
// lost; the rest lies where it belongs.
class EstimateOdometryHiddenView : public EstimateOdometryWalker {};

TEST_P(EstimateOdometryHiddenView, SaysWhichFramesAreLost) {
  const WalkPast walk = RenderWalkPast(GetParam());
  ASSERT_GT(walk.largest_share, GetParam().covered_share);
  const Odometry odometry = Track(walk.frames);
  for (std::size_t k = 0; k < walk.truth.size(); ++k) {
    if (odometry.frames[k].status != TrackingStatus::kTracked) continue;
    EXPECT_THAT(
        (walk.truth[0].Inverse() * walk.truth[k]).Inverse() * odometry.frames[k].world_from_camera,
        PoseNear(Pose3{}, 0.05, 1.5))
        << "frame " << k;
  }
  ExpectTrue(odometry, walk.truth, 0, walk.truth.size() / 2 - 6);
  ExpectTrue(odometry, walk.truth, walk.truth.size() - 10, walk.truth.size());
  ExpectConsistent(odometry);
}

INSTANTIATE_TEST_SUITE_P(Passes,
                         EstimateOdometryHiddenView,
                         ::testing::Values(Walk{"AStandingCamera", 0.0, 0.06, 0.5, 0.90},
                                           Walk{"AMovingCamera", 0.5, 0.06, 0.5, 0.85},
                                           Walk{"AStandingCameraAllCovered", 0.0, 0.06, 0.4, 0.99},
                                           Walk{"AMovingCameraAllCovered", 0.5, 0.06, 0.4, 0.95}),
                         [](const auto& test) { return test.param.name; });

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
  ExpectStatus(odometry, 0, walk.bare_begin - 3, TrackingStatus::kTracked);
  for (std::size_t k = walk.bare_begin; k < walk.bare_end; ++k)
    EXPECT_NE(odometry.frames[k].status, TrackingStatus::kTracked) << "frame " << k;
  ExpectStatus(odometry, walk.bare_end + 6, walk.truth.size(), TrackingStatus::kTracked);
  ExpectTrue(odometry, walk.truth, 0, walk.bare_begin - 3);
  // Behind the bare stretch the pieces fit in themselves.
  ExpectTrue(odometry, walk.truth, walk.bare_end + 6, walk.truth.size());
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
  ExpectStatus(odometry, 0, walk.truth.size(), TrackingStatus::kTracked);
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

TEST(EstimateOdometry, APieceAfterATeleportIsCarriedOverWhenItSeesAnEarlierKeyframe) {
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

// Painted walls, a darker floor, faint patterns: images are alike wherever floor meets wall.
BoxWorld PlainRoom() {
  BoxWorld world = BoxWorld::Furnished();
  world.texture = 0.12;
  world.floor_darker = 60;
  return world;
}

// Furniture stands elsewhere than in the other, and its patterns differ.
BoxWorld OtherPlainRoom(std::uint64_t seed) {
  Random random(seed, "other room", 0);
  BoxWorld world = PlainRoom();
  world.texture_phase = random.Uniform(0.8, 2.4);
  for (Box3& box : world.boxes) {
    const Eigen::Vector3d size = box.max - box.min;
    box.min = {random.Uniform(-1.9, 1.1), random.Uniform(-1.9, 1.1), 0};
    box.max = box.min + size;
  }
  return world;
}

class EstimateOdometryOfTwoRooms : public ::testing::TestWithParam<std::uint64_t> {};

// Walls, floors and corners of one fit somewhere in the other: that is no place.
TEST_P(EstimateOdometryOfTwoRooms, NothingMeasuredTiesThem) {
  const std::vector<Pose3> first = Arc(14, 1.5);
  const std::vector<Pose3> second = Arc(40, 2.0);
  std::vector<Pose3> truth = first;
  truth.insert(truth.end(), second.begin() + 8, second.end());
  std::vector<Frame> frames = Render(PlainRoom(), truth);
  std::vector<Frame> others = Render(OtherPlainRoom(GetParam()), truth);
  std::ranges::move(others.begin() + 14, others.end(), frames.begin() + 14);
  const Odometry odometry = Track(std::move(frames));
  EXPECT_EQ(odometry.frames[14].status, TrackingStatus::kLost);
  ExpectStatus(odometry, 0, 14, TrackingStatus::kTracked);
  for (std::size_t k = 15; k < truth.size(); ++k)
    EXPECT_NE(odometry.frames[k].status, TrackingStatus::kLost) << "frame " << k;
  for (const RelativePose& edge : odometry.edges)
    EXPECT_EQ(edge.composed, (edge.i.value < 14) != (edge.j.value < 14))
        << edge.i << " to " << edge.j;
  ExpectTrue(odometry, truth, 0, 14);
  ExpectTrue(odometry, truth, 14, truth.size(), 0.03, 0.8);
  ExpectConsistent(odometry);
}

// The second is seen from just where the camera was expected to go on in the first, and most of its
// depth fits there.
TEST_P(EstimateOdometryOfTwoRooms, TheSecondIsNotTakenForTheFirstWhereItWasExpected) {
  const std::vector<Pose3> truth = Arc(28, 2.0);
  BoxWorld first = PlainRoom();
  first.texture = 0.6;
  BoxWorld second = first;
  second.texture_phase = OtherPlainRoom(GetParam()).texture_phase;
  second.boxes.erase(second.boxes.begin() + static_cast<std::ptrdiff_t>(GetParam() % 2));
  std::vector<Frame> frames = Render(first, truth);
  std::vector<Frame> others = Render(second, truth);
  std::ranges::move(others.begin() + 14, others.end(), frames.begin() + 14);
  const Odometry odometry = Track(std::move(frames));
  EXPECT_EQ(odometry.frames[14].status, TrackingStatus::kLost);
  for (const RelativePose& edge : odometry.edges)
    EXPECT_EQ(edge.composed, (edge.i.value < 14) != (edge.j.value < 14))
        << edge.i << " to " << edge.j;
  ExpectTrue(odometry, truth, 0, 14);
  ExpectTrue(odometry, truth, 14, truth.size(), 0.03, 0.8);
}

INSTANTIATE_TEST_SUITE_P(Seeds, EstimateOdometryOfTwoRooms, ::testing::Range<std::uint64_t>(1, 7));

// As above, behind a covered lens: none of the keyframes that are tried again is the place either.
TEST(EstimateOdometry, AnotherRoomBehindACoveredLensIsNoKeyframesPlace) {
  const std::vector<Pose3> truth = Arc(44, 2.0);
  std::vector<Frame> frames = Render(PlainRoom(), truth);
  std::vector<Frame> others = Render(OtherPlainRoom(3), truth);
  std::ranges::move(others.begin() + 28, others.end(), frames.begin() + 28);
  for (std::size_t k = 22; k < 28; ++k) std::ranges::fill(frames[k].depth_m, 0.0F);
  const Odometry odometry = Track(std::move(frames));
  ExpectStatus(odometry, 22, 29, TrackingStatus::kLost);
  for (const RelativePose& edge : odometry.edges)
    EXPECT_EQ(edge.composed, (edge.i.value < 28) != (edge.j.value < 28))
        << edge.i << " to " << edge.j;
  ExpectTrue(odometry, truth, 28, truth.size(), 0.03, 0.8);
}

// The same rooms one floor up, papered anew: all depth fits, and it is still not the place.
TEST(EstimateOdometry, AnEarlierKeyframesPlaceMustLookLikeIt) {
  std::vector<Pose3> truth = Arc(22, 2.0);
  const std::vector<Pose3> start = Arc(12, 2.0);
  truth.insert(truth.end(), start.begin(), start.end());
  BoxWorld below = PlainRoom();
  below.texture = 0.6;
  const auto found = [&](const BoxWorld& above) {
    std::vector<Frame> frames = Render(below, truth);
    std::vector<Frame> others = Render(above, truth);
    std::ranges::move(others.begin() + 22, others.end(), frames.begin() + 22);
    const Odometry odometry = Track(std::move(frames));
    return std::ranges::any_of(odometry.edges, [](const RelativePose& edge) {
      return !edge.composed && edge.i.value < 22 && edge.j.value >= 22;
    });
  };
  EXPECT_TRUE(found(below));
  BoxWorld above = below;
  above.texture_phase = 2.0;
  EXPECT_FALSE(found(above));
}

struct Leap {
  std::string name;
  double turn_deg;  // round the room
};

void PrintTo(const Leap& leap, std::ostream* out) { *out << leap.name; }

class EstimateOdometryLeap : public ::testing::TestWithParam<Leap> {};

// Farther than a hand goes, and back in sight of what was seen: found there at once.
TEST_P(EstimateOdometryLeap, WithinSightIsRight) {
  std::vector<Pose3> truth = Arc(10, 1.5);
  const double step_deg = 1.5;
  const auto skipped = static_cast<std::size_t>(GetParam().turn_deg / step_deg);
  const std::vector<Pose3> whole = Arc(static_cast<int>(20 + skipped), step_deg);
  for (std::size_t k = 10 + skipped; k < whole.size(); ++k) truth.push_back(whole[k]);
  const Odometry odometry = Track(Render(BoxWorld::Furnished(), truth));
  ExpectStatus(odometry, 0, truth.size(), TrackingStatus::kTracked);
  ExpectTrue(odometry, truth, 0, truth.size(), 0.03, 0.8);
  ExpectHonestEdges(odometry, truth);
}

INSTANTIATE_TEST_SUITE_P(Leaps,
                         EstimateOdometryLeap,
                         ::testing::Values(Leap{"OfHalfAMetre", 21},
                                           Leap{"OfThreeQuartersOfAMetre", 30}),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace deepslam::tracking
