// Places that look alike are told apart, and places that are the same are found again.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deepslam/core/random.h"
#include "tracking/tracked_sequence.h"

namespace deepslam::tracking {
namespace {

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

// Farther than a hand goes, and back in view of what was seen: found there at once.
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
