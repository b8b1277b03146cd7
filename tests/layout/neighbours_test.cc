#include "deepslam/layout/neighbours.h"

#include <gtest/gtest.h>

namespace deepslam::layout {
namespace {

PlacedThing At(const Eigen::Vector3d& middle, const Eigen::Vector3d& size, double turned_deg = 0) {
  const double rad = turned_deg * 3.14159265358979 / 180;
  return {{{Eigen::Quaterniond(Eigen::AngleAxisd(rad, Eigen::Vector3d::UnitZ())), middle}, size},
          0,
          true};
}
const Eigen::Vector3d kCube(1, 1, 1);

TEST(NeighboursOf, BesideIsNearAndAtOneHeight) {
  const auto of = [](const PlacedThing& other) {
    return NeighboursOf(std::vector<PlacedThing>{At({0, 0, 0.5}, kCube), other});
  };
  const auto beside = of(At({0, 1.3, 0.5}, kCube));
  ASSERT_EQ(beside.size(), 1U);
  EXPECT_TRUE(beside[0].beside);
  EXPECT_FALSE(beside[0].before);
  EXPECT_NEAR(beside[0].distance_m, 0.3, 1e-9);
  EXPECT_TRUE(of(At({0, 1.6, 0.5}, kCube)).empty()) << "0.6 m apart";
  EXPECT_TRUE(of(At({0, 1.3, 1.6}, kCube)).empty()) << "above it";
  // Turned by 45 deg a corner points at the other's side.
  const auto turned = of(At({0, 1.5, 0.5}, kCube, 45));
  ASSERT_EQ(turned.size(), 1U);
  EXPECT_NEAR(turned[0].distance_m, 1.5 - 0.5 - std::sqrt(0.5), 1e-9);
  const auto over = of(At({0, 0.5, 0.4}, {0.5, 0.5, 0.8}));
  ASSERT_EQ(over.size(), 1U);
  EXPECT_EQ(over[0].distance_m, 0) << "they overlap on the plan";
}

TEST(NeighboursOf, BeforeIsOnTheSideOfTheFront) {
  const PlacedThing sofa = At({0, 0, 0.5}, kCube, 90);  // its front looks along y
  const auto before = [&](const Eigen::Vector3d& middle) {
    for (const Neighbours& pair : NeighboursOf(std::vector{sofa, At(middle, {0.4, 0.4, 0.4})})) {
      if (pair.before && pair.first == 1) return true;
    }
    return false;
  };
  EXPECT_TRUE(before({0, 1.5, 0.2}));
  EXPECT_TRUE(before({0.4, 0.9, 0.2}));
  EXPECT_FALSE(before({0.6, 0.9, 0.2})) << "past its side";
  EXPECT_FALSE(before({0, 2.1, 0.2})) << "too far";
  EXPECT_FALSE(before({0, -1.5, 0.2})) << "behind it";
  EXPECT_FALSE(before({1.5, 0, 0.2})) << "at its side";
}

TEST(NeighboursOf, RoomsAndMissingFrontsKeepThingsApart) {
  std::vector<PlacedThing> things = {At({0, 0, 0.5}, kCube), At({1.2, 0, 0.5}, kCube)};
  const std::vector<Neighbours> pairs = NeighboursOf(things);
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_TRUE(pairs[0].beside && !pairs[0].before) << "the first is behind the second";
  EXPECT_TRUE(pairs[1].before && pairs[1].first == 1);
  things[0].has_front = false;
  things[1].box.world_from_object.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(3.14159265358979, Eigen::Vector3d::UnitZ()));
  ASSERT_EQ(NeighboursOf(things).size(), 1U);
  EXPECT_TRUE(NeighboursOf(things)[0].before) << "the second faces the first now";
  things[1].room = 1;
  EXPECT_TRUE(NeighboursOf(things).empty());
  things[1].room.reset();
  EXPECT_EQ(NeighboursOf(things).size(), 1U) << "in no room is near as well";
}

TEST(NeighboursOf, BearsEmptyBoxesAndNone) {
  EXPECT_TRUE(NeighboursOf({}).empty());
  EXPECT_TRUE(
      NeighboursOf(std::vector{At({0, 0, 0}, {0, 0, 0}), At({0.1, 0, 0}, {0, 0, 0})}).size() <= 1U);
}

}  // namespace
}  // namespace deepslam::layout
