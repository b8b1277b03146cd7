#include "deepslam/scene/observed_space.h"

#include <limits>
#include <utility>

#include <gtest/gtest.h>

namespace deepslam {
namespace {

SpaceBlock BlockAt(int x, int y, int z) {
  SpaceBlock block;
  block.index = {x, y, z};
  return block;
}

TEST(ObservedSpace, FindsVoxelsOnBothSidesOfTheOrigin) {
  SpaceBlock low = BlockAt(-1, -1, -1);
  low.passed.back() = 7;  // touches the origin
  SpaceBlock high = BlockAt(0, 0, 0);
  high.passed.front() = 9;
  high.blind[1] = 3;  // one further along z
  const ObservedSpace space(0.1, {std::move(low), std::move(high)});
  EXPECT_EQ(space.Passed({-0.05, -0.05, -0.05}), 7);
  EXPECT_EQ(space.Passed({0.05, 0.05, 0.05}), 9);
  EXPECT_EQ(space.Blind({0.05, 0.05, 0.15}), 3);
  EXPECT_EQ(space.Passed({0.05, 0.05, 0.15}), 0);
}

TEST(ObservedSpace, KnowsNothingOfWhatWasNotLookedAt) {
  const ObservedSpace space(0.1, {BlockAt(3, 0, 0)});
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const Eigen::Vector3d& point : {Eigen::Vector3d(0, 0, 0),
                                       Eigen::Vector3d(100, 0, 0),
                                       Eigen::Vector3d(-1e300, 0, 0),
                                       Eigen::Vector3d(kNan, 0, 0)}) {
    EXPECT_EQ(space.Passed(point), 0);
    EXPECT_EQ(space.Blind(point), 0);
  }
  EXPECT_EQ(ObservedSpace().Passed({0, 0, 0}), 0);
}

}  // namespace
}  // namespace deepslam
