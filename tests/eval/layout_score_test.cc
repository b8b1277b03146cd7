#include "deepslam/eval/layout_score.h"

#include <vector>

#include <gtest/gtest.h>

namespace deepslam::eval {
namespace {

const std::vector<Eigen::Vector2d> kCorners = {{0, 0}, {4, 0}, {4, 3}, {0, 3}};

// A room of 4 x 3 m with a door in its south wall and a window in its north wall.
Layout Room() {
  Layout layout;
  LayoutRoom room;
  room.polygon_m = kCorners;
  room.guessed.assign(4, false);
  layout.rooms = {room};
  for (std::size_t n = 0; n < 4; ++n) {
    LayoutWall wall;
    wall.from_m = kCorners[n];
    wall.to_m = kCorners[(n + 1) % 4];
    wall.top_m = 2.5;
    wall.rooms = {0};
    layout.walls.push_back(wall);
  }
  LayoutOpening door;
  door.wall = 0;
  door.from_m = {1, 0};
  door.to_m = {1.9, 0};
  door.top_m = 2;
  LayoutOpening window;
  window.wall = 2;
  window.kind = OpeningKind::kWindow;
  window.from_m = {3, 3};
  window.to_m = {1.8, 3};
  window.bottom_m = 0.9;
  window.top_m = 2.1;
  layout.openings = {door, window};
  return layout;
}

TrueLayout TruthOf(const Layout& layout) {
  TrueLayout truth;
  truth.rooms = {layout.rooms[0].polygon_m};
  for (const LayoutWall& wall : layout.walls)
    truth.walls.push_back({wall.from_m, wall.to_m, 0, wall.bottom_m, wall.top_m});
  for (const LayoutOpening& o : layout.openings)
    truth.openings.push_back({o.kind, o.from_m, o.to_m, 0, o.bottom_m, o.top_m});
  return truth;
}

// Points all over the walls, but for those that `seen` leaves out.
std::vector<Eigen::Vector3d> Surface(const Layout& layout, const std::vector<bool>& seen) {
  std::vector<Eigen::Vector3d> points;
  for (std::size_t n = 0; n < layout.walls.size(); ++n) {
    if (!seen[n]) continue;
    const LayoutWall& wall = layout.walls[n];
    for (double s = 0.01; s < 1; s += 0.01) {
      const Eigen::Vector2d p = wall.from_m + s * (wall.to_m - wall.from_m);
      for (double z = 0.05; z < 2.5; z += 0.05) points.emplace_back(p.x(), p.y(), z);
    }
  }
  return points;
}

LayoutScore Score(const Layout& layout, const std::vector<bool>& seen = {true, true, true, true}) {
  return ScoreLayout(layout, TruthOf(Room()), Surface(Room(), seen), LayoutScoreOptions());
}

TEST(LayoutScore, TheTruthIsRight) {
  const LayoutScore score = Score(Room());
  EXPECT_EQ(score.wall_recall(), 1);
  EXPECT_EQ(score.wall_precision(), 1);
  ASSERT_EQ(score.corner_m.size(), 4U);
  EXPECT_EQ(score.corner_m[0], 0);
  ASSERT_EQ(score.room_area_error.size(), 1U);
  EXPECT_EQ(score.room_area_error[0], 0);
  for (const KindScore& kind : score.openings) EXPECT_EQ(kind.f1(), 1);
  EXPECT_EQ(score.num_openings_any_kind, 2);
}

TEST(LayoutScore, NothingIsNoClaim) {
  const LayoutScore score = Score(Layout());
  EXPECT_EQ(score.wall_recall(), 0);
  EXPECT_EQ(score.wall_precision(), 1);
  EXPECT_TRUE(score.room_area_error.empty());
  EXPECT_EQ(score.openings[0].recall(), 0);
}

TEST(LayoutScore, OnlyWhatWasSeenIsAskedFor) {
  Layout layout = Room();
  layout.walls.erase(layout.walls.begin() + 1);
  EXPECT_EQ(Score(layout).wall_recall(), 0.75);
  EXPECT_EQ(Score(layout).missed_walls, std::vector<int>{1});
  EXPECT_EQ(Score(layout, {true, false, true, true}).wall_recall(), 1);
}

TEST(LayoutScore, HoldsDistanceAngleAndLength) {
  const auto with_wall = [](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    Layout layout = Room();
    layout.walls[0].from_m = from;
    layout.walls[0].to_m = to;
    return Score(layout).num_found_walls;
  };
  EXPECT_EQ(with_wall({0, 0.08}, {4, 0.08}), 4);
  EXPECT_EQ(with_wall({0, 0.13}, {4, 0.13}), 3);
  EXPECT_EQ(with_wall({0.5, -0.05}, {3.2, 0.05}), 4);  // 67 % of it
  EXPECT_EQ(with_wall({0.5, 0}, {2.5, 0}), 3);         // 50 %
  EXPECT_EQ(with_wall({0, -0.2}, {4, 0.2}), 3);        // 5.7 deg
}

TEST(LayoutScore, AWallInAThickBoxMayStandAnywhereInIt) {
  TrueLayout truth;
  truth.walls = {{{0, 0.3}, {4, 0.3}, 0.7, 0, 2.5}};
  Layout layout = Room();
  layout.walls.resize(1);
  const LayoutScore score =
      ScoreLayout(layout, truth, Surface(Room(), {true, false, false, false}), {});
  EXPECT_EQ(score.num_true_walls, 1);
  EXPECT_EQ(score.num_found_walls, 1);
  EXPECT_EQ(score.num_right_walls, 1);
}

TEST(LayoutScore, OpeningsAreScoredByKindAndOverlap) {
  Layout layout = Room();
  layout.openings[0].kind = OpeningKind::kPassage;
  layout.openings[1].bottom_m = 1.8;
  const LayoutScore score = Score(layout);
  EXPECT_EQ(score.openings[0].recall(), 0);  // the door is called a passage
  EXPECT_EQ(score.openings[2].precision(), 0);
  EXPECT_EQ(score.openings[1].recall(), 0);  // a quarter of the window
  EXPECT_EQ(score.num_openings_any_kind, 1);
}

}  // namespace
}  // namespace deepslam::eval
