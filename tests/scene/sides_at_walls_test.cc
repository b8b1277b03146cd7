#include "deepslam/scene/sides_at_walls.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deepslam/core/angles.h"

namespace deepslam {
namespace {

using testing::ElementsAre;

// A room of 4 x 3 m, its corner at the origin: walls along y = 0 and x = 0, which it lies left of.
Layout Corner() {
  Layout layout;
  for (const auto& [from, to] : {std::pair<Eigen::Vector2d, Eigen::Vector2d>{{0, 0}, {4, 0}},
                                 std::pair<Eigen::Vector2d, Eigen::Vector2d>{{0, 3}, {0, 0}}}) {
    LayoutWall wall;
    wall.from_m = from;
    wall.to_m = to;
    wall.top_m = 2.5;
    layout.walls.push_back(wall);
  }
  return layout;
}

Pose3 Standing(const Eigen::Vector3d& place_m, double yaw_deg) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(yaw_deg * kRadPerDeg, Eigen::Vector3d::UnitZ())),
          place_m};
}

// 0.6 m deep along x, 1 m wide, 0.8 m high.
const Eigen::Vector3d kSize_m(0.6, 1.0, 0.8);

TEST(SidesAtWalls, TheSideAtTheWallIsFoundAtEveryTurn) {
  // Its depth across the wall at y = 0: the back is -x at 90 deg, and the front is -x there at 270.
  const Eigen::Vector3d place_m(2, 0.35, 0.4);
  EXPECT_THAT(FindSidesAtWalls(Corner(), Standing(place_m, 90), kSize_m),
              ElementsAre(false, false, true, false));
  EXPECT_THAT(FindSidesAtWalls(Corner(), Standing(place_m, 100), kSize_m),
              ElementsAre(false, false, true, false));
  EXPECT_THAT(FindSidesAtWalls(Corner(), Standing(place_m, 270), kSize_m),
              ElementsAre(true, false, false, false));
}

TEST(SidesAtWalls, ACornerHasTwo) {
  EXPECT_THAT(FindSidesAtWalls(Corner(), Standing({0.55, 0.35, 0.4}, 90), kSize_m),
              ElementsAre(false, true, true, false));
}

TEST(WallConflict, IsThatOfTheFrontUnlessItReachesFarThroughAWall) {
  const Layout layout = Corner();
  const auto conflict = [&](const Eigen::Vector3d& place_m, double yaw_deg) {
    return WallConflict(layout, Standing(place_m, yaw_deg), kSize_m);
  };
  EXPECT_EQ(conflict({2, 0.35, 0.4}, 90), 0) << "its back at the wall";
  EXPECT_EQ(conflict({2, 0.35, 0.4}, 270), 1) << "its front";
  EXPECT_EQ(conflict({2, 0.55, 0.4}, 0), 0.5) << "its side";
  EXPECT_EQ(conflict({2, 0.2, 0.4}, 90), 0) << "10 cm through it";
  EXPECT_EQ(conflict({2, -0.05, 0.4}, 90), 1) << "35 cm through it";
  EXPECT_EQ(conflict({2, 1.5, 0.4}, 0), 0) << "in the room";
}

TEST(SidesAtWalls, ASideThroughTheWallStandsAtIt) {
  // Its width across the wall: it ends 0.4 m behind the face.
  EXPECT_THAT(FindSidesAtWalls(Corner(), Standing({2, 0.1, 0.4}, 0), kSize_m),
              ElementsAre(false, false, false, true));
  EXPECT_THAT(FindSidesAtWalls(Corner(), Standing({2, -0.3, 0.4}, 0), kSize_m),
              ElementsAre(false, false, false, true))
      << "most of it is behind the face";
}

TEST(SidesAtWalls, NoneAwayFromWallsBesideThemAboveThemOrBehindThem) {
  const auto none = ElementsAre(false, false, false, false);
  EXPECT_THAT(FindSidesAtWalls(Corner(), Standing({2, 1.5, 0.4}, 90), kSize_m), none);
  EXPECT_THAT(FindSidesAtWalls(Corner(), Standing({4.2, 0.35, 0.4}, 90), kSize_m), none);
  EXPECT_THAT(FindSidesAtWalls(Corner(), Standing({2, 0.35, 3}, 90), kSize_m), none);
  EXPECT_THAT(FindSidesAtWalls(Corner(), Standing({2, -0.35, 0.4}, 90), kSize_m), none);
  EXPECT_THAT(FindSidesAtWalls(Corner(), Standing({2, 0.45, 0.4}, 45), kSize_m), none);
}

TEST(SidesAtWalls, NoneOfWallsWithoutLengthOrPlacesThatAreNone) {
  Layout layout = Corner();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(FindSidesAtWalls(layout, Standing({nan, 0.35, 0.4}, 90), kSize_m),
              testing::Each(false));
  for (LayoutWall& wall : layout.walls) wall.to_m = wall.from_m;
  EXPECT_THAT(FindSidesAtWalls(layout, Standing({2, 0.35, 0.4}, 90), kSize_m),
              testing::Each(false));
  EXPECT_THAT(FindSidesAtWalls({}, Standing({2, 0.35, 0.4}, 90), kSize_m), testing::Each(false));
}

TEST(SidesAtWalls, AFrontIsBlockedMostAtAWallAndLeastWithItsBackAtOne) {
  const SidesAtWalls back = {false, false, true, false};
  EXPECT_EQ(FrontBlocked(back, 0), 0);
  EXPECT_EQ(FrontBlocked(back, 2), 1);
  EXPECT_GT(FrontBlocked(back, 1), 0);
  EXPECT_LT(FrontBlocked(back, 1), 1);
  EXPECT_EQ(FrontBlocked(back, 1), FrontBlocked(back, 3));
  const SidesAtWalls corner = {false, true, true, false};
  EXPECT_EQ(FrontBlocked(corner, 0), 0);
  EXPECT_EQ(FrontBlocked(corner, 3), 0);
  const SidesAtWalls niche = {true, false, true, false};
  EXPECT_EQ(FrontBlocked(niche, 0), 0) << "walls do not tell front from back";
  EXPECT_EQ(FrontBlocked(niche, 2), 0);
  for (int side = 0; side < 4; ++side) EXPECT_EQ(FrontBlocked({}, side), 0);
}

}  // namespace
}  // namespace deepslam
