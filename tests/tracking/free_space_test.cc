// Frames that are placed rightly see through nothing that stands, wrongly placed ones do.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Core>

#include "alignment/box_world.h"
#include "alignment/rendered_pyramids.h"
#include "deepslam/tracking/free_space.h"

namespace deepslam::tracking {
namespace {

using ::testing::Gt;
using ::testing::Lt;
using testing_support::Arc;
using testing_support::BoxWorld;
using testing_support::kRadPerDeg;
using testing_support::LookAt;
using testing_support::Seen;

std::vector<PlacedPyramid> Placed(const BoxWorld& world, const std::vector<Pose3>& poses) {
  std::vector<PlacedPyramid> placed;
  for (std::size_t k = 0; k < poses.size(); ++k)
    placed.push_back({Seen(world, poses[k], k), poses[k]});
  return placed;
}

// The same walls and floor, other furniture.
BoxWorld OtherRoom() {
  BoxWorld world = BoxWorld::Furnished();
  world.boxes = {{{-0.6, 0.2, 0}, {0.1, 0.9, 0.5}},
                 {{0.6, -1.0, 0}, {1.2, -0.5, 1.0}},
                 {{-1.5, 0.6, 0}, {-0.9, 1.5, 0.7}}};
  world.texture_phase = 1.3;
  return world;
}

TEST(FreeSpaceViolation, IsNextToNothingWhereFramesArePlacedRightly) {
  const std::vector<PlacedPyramid> frames = Placed(BoxWorld::Furnished(), Arc(4, 12.0));
  const std::span<const PlacedPyramid> all = frames;
  EXPECT_THAT(FreeSpaceViolation(all.first(2), all.last(2), {}), Lt(0.005));
}

TEST(FreeSpaceViolation, NeverDependsOnWhoObservesWhom) {
  const std::vector<PlacedPyramid> here = Placed(BoxWorld::Furnished(), Arc(1));
  const std::vector<PlacedPyramid> there = Placed(OtherRoom(), Arc(1, 1.0));
  EXPECT_EQ(FreeSpaceViolation(here, there, {}), FreeSpaceViolation(there, here, {}));
}

TEST(FreeSpaceViolation, TellsRoomsThatShareWallsAndFloor) {
  const std::vector<PlacedPyramid> here = Placed(BoxWorld::Furnished(), Arc(3, 12.0));
  const std::vector<PlacedPyramid> there = Placed(OtherRoom(), Arc(3, 12.0));
  EXPECT_THAT(FreeSpaceViolation(here, there, {}), Gt(0.05));
}

// The floor and the walls of a square room lie on themselves again, what stands there does not.
TEST(FreeSpaceViolation, TellsASquareRoomFromItselfTurnedRound) {
  std::vector<PlacedPyramid> frames = Placed(BoxWorld::Furnished(), Arc(1));
  for (const double turn_deg : {90.0, 180.0, 270.0}) {
    const Eigen::Quaterniond turn(
        Eigen::AngleAxisd(turn_deg * kRadPerDeg, Eigen::Vector3d::UnitZ()));
    PlacedPyramid turned = frames.front();
    // Seen from where the camera is as well, or neither tells anything.
    const Pose3 truth = Pose3{turn.inverse(), Eigen::Vector3d::Zero()} * Arc(1).front();
    turned.pyramid = Seen(BoxWorld::Furnished(), truth);
    EXPECT_THAT(FreeSpaceViolation(frames, {&turned, 1}, {}), Gt(0.05)) << turn_deg;
  }
}

TEST(FreeSpaceViolation, SaysNothingOfFramesThatLookElsewhere) {
  const BoxWorld world = BoxWorld::Furnished();
  const std::vector<PlacedPyramid> there = Placed(world, {LookAt({0, 0, 1.2}, {-2, 0, 1.2})});
  const std::vector<PlacedPyramid> back = Placed(world, {LookAt({0, 0, 1.2}, {2, 0, 1.2})});
  EXPECT_EQ(FreeSpaceViolation(there, back, {}), 0);
}

}  // namespace
}  // namespace deepslam::tracking
