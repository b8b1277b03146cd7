// What a frame shows of the ground, and the clusters on it.
#include "deepslam/detect/ground_clusters.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>

#include "deepslam/detect/ground_grid.h"
#include "deepslam/detect/seen_ends.h"
#include "support/box_world.h"

namespace deepslam::detect {
namespace {

using namespace testing_support;  // NOLINT

const Cuboid kCabinet = {0, {-0.4, -0.25, 0}, {0.4, 0.25, 0.6}};
const Cuboid kWall = {-1, {-4, 1.2, 0}, {4, 1.3, 2.6}};

struct Look {
  Pose3 world_from_camera;
  BoxView view;
  Plane ground;
  GroundGrid grid;

  explicit Look(const std::vector<Cuboid>& world,
                const Eigen::Vector3d& eye = {0.8, -2.0, 1.3},
                const Eigen::Vector3d& target = {0, 0, 0.3})
      : world_from_camera(LookAt(eye, target)),
        view(RenderBoxes(world, SmallCamera(), world_from_camera)),
        ground(FloorIn(world_from_camera)),
        grid(SurveyGround(view.frame, SmallCamera(), ground)) {}

  [[nodiscard]] double HeightAt(int u, int v) const {
    return ground.SignedDistance(SmallCamera().Unproject(u, v, view.frame.depth_m(u, v)));
  }
};

TEST(SurveyGround, PointsAreThoseAboveTheFloorAndOfNoWall) {
  const Look look({kCabinet, kWall});
  ASSERT_GT(look.grid.points.size(), 1000U);
  for (const GridPoint& p : look.grid.points) {
    EXPECT_EQ(look.view.object(p.u, p.v), 0);
    EXPECT_NEAR(p.height_m, look.HeightAt(p.u, p.v), 1e-4);
    EXPECT_EQ(look.grid.wall(p.u, p.v), 0);
  }
  std::size_t num_wall = 0;
  for (const std::uint8_t wall : look.grid.wall) num_wall += wall;
  EXPECT_GT(num_wall, 1000U);
}

TEST(SurveyGround, CellsOfMatterHoldPointsAndCellsOfFloorAreSeen) {
  const Look look({kCabinet});
  std::vector<int> num_points(look.grid.kinds.size());
  for (const GridPoint& p : look.grid.points) ++num_points[static_cast<std::size_t>(p.cell)];
  std::size_t num_floor = 0;
  std::size_t num_matter = 0;
  for (std::size_t n = 0; n < num_points.size(); ++n) {
    num_floor += (look.grid.kinds[n] & kFloor) != 0 ? 1 : 0;
    if ((look.grid.kinds[n] & kMatter) == 0) continue;
    ++num_matter;
    EXPECT_GT(num_points[n], 0);
  }
  EXPECT_GT(num_floor, 100U);
  // The two sides and the top that are seen, 0.8 m by 0.5 m in cells of 4 cm.
  EXPECT_NEAR(static_cast<double>(num_matter), 0.8 * 0.5 / (0.04 * 0.04), 120);
}

TEST(FindGroundClusters, MeasuresAThingOnTheFloor) {
  const Look look({kCabinet});
  const Components components = ConnectCells(look.grid);
  std::vector<Cluster> clusters = FindGroundClusters(320, look.grid, components, 300);
  ASSERT_EQ(clusters.size(), 1U);
  Cluster& cabinet = clusters[0];
  EXPECT_TRUE(IsFurniture(cabinet));
  EXPECT_NEAR(cabinet.max_height_m, 0.6, 0.03);
  EXPECT_NEAR(cabinet.long_side_m, 0.8, 0.08);
  EXPECT_NEAR(cabinet.short_side_m, 0.5, 0.08);
  EXPECT_GT(FreeShare(look.grid, components, cabinet), 0.9);
  EXPECT_TRUE(EndsAreSeen(look.view.frame, SmallCamera(), look.ground, look.grid.wall, cabinet));
}

TEST(FindGroundClusters, ThingsApartAreClustersOfTheirOwnLargestFirst) {
  const Look look(
      {kCabinet, {1, {1.2, -0.1, 0}, {1.5, 0.2, 0.5}}}, {0.8, -2.5, 1.6}, {0.4, 0, 0.2});
  const std::vector<Cluster> clusters =
      FindGroundClusters(320, look.grid, ConnectCells(look.grid), 100);
  ASSERT_EQ(clusters.size(), 2U);
  EXPECT_GE(clusters[0].num_points, clusters[1].num_points);
  for (const Cluster& cluster : clusters) {
    const int object = look.view.object(cluster.points[0].u, cluster.points[0].v);
    for (const GridPoint& p : cluster.points) EXPECT_EQ(look.view.object(p.u, p.v), object);
  }
}

TEST(EndsAreSeen, NotOfWhatRunsOnBehindSomethingNearer) {
  // A board before the left half of the cabinet.
  const Look look({kCabinet, {1, {-1.0, -0.9, 0}, {0.0, -0.85, 0.9}}}, {0.6, -2.2, 1.0});
  std::vector<Cluster> clusters = FindGroundClusters(320, look.grid, ConnectCells(look.grid), 300);
  const auto cabinet = std::ranges::find_if(clusters, [&](const Cluster& cluster) {
    return !cluster.points.empty() &&
           look.view.object(cluster.points[0].u, cluster.points[0].v) == 0;
  });
  ASSERT_NE(cabinet, clusters.end());
  EXPECT_FALSE(EndsAreSeen(look.view.frame, SmallCamera(), look.ground, look.grid.wall, *cabinet));
}

TEST(SurveyGround, NothingComesOfAnImageWithoutDepth) {
  Frame frame;
  frame.depth_m = DepthImage(64, 48, 0.0F);
  const GroundGrid grid = SurveyGround(frame, SmallCamera(), {Eigen::Vector3d(0, -1, 0), 1.4});
  EXPECT_TRUE(grid.points.empty());
  EXPECT_TRUE(std::ranges::all_of(grid.kinds, [](std::uint8_t kind) { return kind == 0; }));
  EXPECT_EQ(ConnectCells(grid).count, 0);
}

}  // namespace
}  // namespace deepslam::detect
