#include "deepslam/scene/wall_geometry.h"

#include <gtest/gtest.h>

#include "support/layout_samples.h"

namespace deepslam {
namespace {

TEST(WallGeometry, AWallIsAsThickAsItsFacesAreApart) {
  const Layout layout = testing_support::TwoRoomLayout();
  EXPECT_NEAR(ThicknessOf(layout, layout.walls[1]).value_or(-1), 0.1, 1e-9);
  EXPECT_NEAR(ThicknessOf(layout, layout.walls[7]).value_or(-1), 0.1, 1e-9);
  EXPECT_FALSE(ThicknessOf(layout, layout.walls[0]).has_value());
  EXPECT_FALSE(ThicknessOf(layout, layout.walls[3]).has_value()) << "the room is no wall";
}

TEST(WallGeometry, AnOpeningGoesThroughBothFacesOfItsWall) {
  const Layout layout = testing_support::TwoRoomLayout();
  for (std::size_t wall = 0; wall < layout.walls.size(); ++wall)
    EXPECT_EQ(GoesThrough(layout, layout.openings[0], layout.walls[wall]), wall == 7) << wall;
  const auto [first, second] = SpanOf(layout.openings[0], layout.walls[7]);
  EXPECT_NEAR(first, 1.1, 1e-9);
  EXPECT_NEAR(second, 2.0, 1e-9);
}

TEST(WallGeometry, CornersOfARoomAreHollowAndThoseOfAPillarAreNot) {
  Layout layout = testing_support::TwoRoomLayout();
  for (const LayoutWall& wall : layout.walls) {
    EXPECT_TRUE(MeetsInHollowCorner(layout, wall, true));
    EXPECT_TRUE(MeetsInHollowCorner(layout, wall, false));
  }
  for (LayoutWall& wall : layout.walls) std::swap(wall.from_m, wall.to_m);
  for (const LayoutWall& wall : layout.walls) {
    EXPECT_FALSE(MeetsInHollowCorner(layout, wall, true));
    EXPECT_FALSE(MeetsInHollowCorner(layout, wall, false));
  }
}

TEST(WallGeometry, AWallWithoutLengthHasADirection) {
  EXPECT_EQ(AlongOf(LayoutWall()), Eigen::Vector2d::UnitX());
  EXPECT_FALSE(ThicknessOf(Layout(), LayoutWall()).has_value());
}

TEST(WallGeometry, ACeilingThatWasNotSeenIsNoneUnderAnyFloor) {
  LayoutRoom room;
  for (const double floor_m : {-0.01, 0.0, 0.3}) {
    room.floor_m = floor_m;
    room.ceiling_m = 0;
    EXPECT_FALSE(HasCeiling(room));
    room.ceiling_m = 2.5;
    EXPECT_TRUE(HasCeiling(room));
  }
}

}  // namespace
}  // namespace deepslam
