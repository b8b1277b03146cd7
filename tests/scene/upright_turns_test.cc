#include "deepslam/scene/upright_turns.h"

#include <numbers>
#include <vector>

#include <gmock/gmock.h>

namespace deepslam {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::ElementsAreArray;

// World: z up, ground z = 0. Level, looking along x, turned clockwise about the optical axis.
Pose3 Held(double roll_deg, double pitch_down_deg = 0) {
  Eigen::Matrix3d level;
  level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const auto turn = [](double deg, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(deg * std::numbers::pi / 180, axis);
  };
  return {Eigen::Quaterniond(level * turn(-pitch_down_deg, Eigen::Vector3d::UnitX()) *
                             turn(roll_deg, Eigen::Vector3d::UnitZ())),
          {0, 0, 1.4}};
}

std::vector<TrackedFrame> Frames(const std::vector<Pose3>& poses) {
  std::vector<TrackedFrame> frames;
  for (const Pose3& pose : poses) {
    TrackedFrame frame;
    frame.frame = FrameIdx{static_cast<std::int32_t>(frames.size())};
    frame.world_from_camera = pose;
    frames.push_back(frame);
  }
  return frames;
}

Ground Floor() {
  Ground ground;
  ground.plane_world = Plane{Eigen::Vector3d::UnitZ(), 0};
  return ground;
}

TEST(UprightTurns, FollowTheCameraAsItIsTurned) {
  EXPECT_THAT(UprightTurns(Frames({Held(10), Held(80), Held(95), Held(175), Held(-100)}), Floor()),
              ElementsAre(QuarterTurn::kNone,
                          QuarterTurn::kClockwise,
                          QuarterTurn::kClockwise,
                          QuarterTurn::kHalf,
                          QuarterTurn::kAnticlockwise));
}

TEST(UprightTurns, LookingStraightDownAreAsTheOnesBeforeOrAsMostAre) {
  const auto frames = Frames({Held(0, 85), Held(90), Held(0, 85), Held(180, 88), Held(90)});
  EXPECT_THAT(UprightTurns(frames, Floor()), Each(QuarterTurn::kClockwise));
}

TEST(UprightTurns, WithoutAGroundNothingIsTurned) {
  EXPECT_THAT(UprightTurns(Frames({Held(90), Held(180)}), Ground{}), Each(QuarterTurn::kNone));
  EXPECT_TRUE(UprightTurns({}, Floor()).empty());
}

TEST(UprightTurns, WithoutAGroundAreAsTheUserSays) {
  const auto frames = Frames({Held(0), Held(90), Held(0, 85)});
  for (const QuarterTurn said :
       {QuarterTurn::kClockwise, QuarterTurn::kHalf, QuarterTurn::kAnticlockwise}) {
    Ground ground;
    ground.upright = said;
    EXPECT_THAT(UprightTurns(frames, ground), Each(said));
  }
}

TEST(UprightTurns, AGroundThatIsSeenCountsForMoreThanTheUsersWord) {
  Ground floor = Floor();
  floor.upright = QuarterTurn::kHalf;
  EXPECT_THAT(UprightTurns(Frames({Held(0), Held(90)}), floor),
              ElementsAre(QuarterTurn::kNone, QuarterTurn::kClockwise));
  EXPECT_THAT(UprightTurns(Frames({Held(0, 85), Held(0, 88)}), floor), Each(QuarterTurn::kHalf))
      << "it tells nothing here";
}

// Two captures in one, the first of them the longer, and no floor in it.
TEST(UprightTurns, APartWithoutFloorIsTurnedAsTheOtherOrAsTheUserSays) {
  const auto frames = Frames({Held(0), Held(0), Held(0), Held(90), Held(100)});
  Ground ground;
  ground.apart = {{FrameIdx{3}, FrameIdx{5}, Plane{Eigen::Vector3d::UnitZ(), 0}}};
  EXPECT_THAT(UprightTurns(frames, ground), Each(QuarterTurn::kClockwise));
  ground.upright = QuarterTurn::kHalf;
  std::vector<QuarterTurn> expected(3, QuarterTurn::kHalf);
  expected.resize(5, QuarterTurn::kClockwise);
  EXPECT_THAT(UprightTurns(frames, ground), ElementsAreArray(expected));
}

TEST(UprightTurnIn, WithoutAGroundIsAsTheUserSays) {
  OptimizedMap map;
  map.frames = Frames({Held(90)});
  EXPECT_EQ(UprightTurnIn(map, FrameIdx{0}), QuarterTurn::kNone);
  map.upright = QuarterTurn::kAnticlockwise;
  EXPECT_EQ(UprightTurnIn(map, FrameIdx{0}), QuarterTurn::kAnticlockwise);
  map.has_ground = true;
  EXPECT_EQ(UprightTurnIn(map, FrameIdx{0}), QuarterTurn::kClockwise);
}

}  // namespace
}  // namespace deepslam
