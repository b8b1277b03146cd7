#include "deepslam/mapping/measure_walls.h"

#include <cmath>
#include <set>

#include <gmock/gmock.h>
#include <Eigen/Eigenvalues>

#include "deepslam/core/angles.h"
#include "mapping/walked_room.h"

namespace deepslam::mapping {
namespace {

// The room's four walls, each with the room to its left.
Layout WallsOf(const TexturedRoom& room) {
  const Eigen::Vector3d& low = room.room.min;
  const Eigen::Vector3d& high = room.room.max;
  const std::vector<Eigen::Vector2d> corners = {
      {low.x(), low.y()}, {high.x(), low.y()}, {high.x(), high.y()}, {low.x(), high.y()}};
  Layout layout;
  for (std::size_t n = 0; n < corners.size(); ++n) {
    LayoutWall wall;
    wall.from_m = corners[n];
    wall.to_m = corners[(n + 1) % corners.size()];
    wall.top_m = high.z();
    layout.walls.push_back(wall);
  }
  return layout;
}

Result<graph::WallViews> Measured(const std::vector<Frame>& frames,
                                  const std::vector<Pose3>& tracked,
                                  const Layout& layout,
                                  RecordingProgress& progress) {
  const auto source = SourceOf(frames);
  return MeasureWalls(source, TrackedAs(tracked), layout, WallViewOptions(), progress);
}

// Along a path that is a little off, each frame's own planes are the true ones in its true camera.
TEST(MeasureWalls, EachFrameHasItsOwnPlanes) {
  const TexturedRoom room;
  const std::vector<Pose3> truth = loop::testing_support::Round(12, 1);
  const std::vector<Pose3> tracked = Drifting(truth, 2);
  Layout layout = WallsOf(room);
  RecordingProgress progress;
  const auto found = Measured(FramesAlong(room, truth), tracked, layout, progress);
  ASSERT_TRUE(found.ok());
  ASSERT_EQ(found->planes.size(), 4U);
  ASSERT_GT(found->views.size(), 12U) << "corners show two walls";
  std::set<int> walls;
  for (const graph::WallView& view : found->views) {
    walls.insert(view.wall);
    const auto frame = static_cast<std::size_t>(view.keyframe.value);
    const Plane expected =
        Transformed(truth[frame].Inverse(), found->planes[static_cast<std::size_t>(view.wall)]);
    EXPECT_NEAR(view.plane_camera.d_m, expected.d_m, 0.005);
    EXPECT_GT(view.plane_camera.normal.dot(expected.normal), std::cos(0.3 * kRadPerDeg));
    EXPECT_GT(view.information.eigenvalues().real().minCoeff(), 0);
  }
  EXPECT_EQ(walls.size(), 4U);
}

// Turning and shifting the world of tracking changes the walls' planes with it and no view.
TEST(MeasureWalls, GoesWithTheWorldOfTheLayout) {
  const TexturedRoom room;
  const std::vector<Pose3> truth = loop::testing_support::Round(4, 1);
  const Pose3 moved(
      Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized())),
      {3, -1, 2});
  std::vector<Pose3> elsewhere;
  for (const Pose3& pose : truth) elsewhere.push_back(moved * pose);
  Layout layout = WallsOf(room);
  RecordingProgress progress;
  const std::vector<Frame> frames = FramesAlong(room, truth);
  const auto here = Measured(frames, truth, layout, progress);
  layout.level_from_tracking = moved.Inverse();
  const auto there = Measured(frames, elsewhere, layout, progress);
  ASSERT_TRUE(here.ok() && there.ok());
  ASSERT_EQ(here->views.size(), there->views.size());
  for (std::size_t n = 0; n < here->views.size(); ++n) {
    EXPECT_EQ(here->views[n].wall, there->views[n].wall);
    EXPECT_NEAR(here->views[n].plane_camera.d_m, there->views[n].plane_camera.d_m, 1e-6);
  }
  for (std::size_t wall = 0; wall < 4; ++wall) {
    const Plane expected = Transformed(moved, here->planes[wall]);
    EXPECT_NEAR((expected.normal - there->planes[wall].normal).norm(), 0, 1e-9);
    EXPECT_NEAR(expected.d_m, there->planes[wall].d_m, 1e-9);
  }
}

TEST(MeasureWalls, WithoutWallsOrDepthThereIsNothing) {
  const TexturedRoom room;
  const std::vector<Pose3> truth = loop::testing_support::Round(3, 1);
  std::vector<Frame> frames = FramesAlong(room, truth);
  RecordingProgress progress;
  EXPECT_TRUE(Measured(frames, truth, {}, progress)->views.empty());
  // Walls that stand elsewhere than what was measured.
  Layout beside = WallsOf(room);
  for (LayoutWall& wall : beside.walls) {
    const Eigen::Vector2d outward(wall.to_m.y() - wall.from_m.y(), wall.from_m.x() - wall.to_m.x());
    wall.from_m += 0.3 * outward.normalized();
    wall.to_m += 0.3 * outward.normalized();
  }
  EXPECT_TRUE(Measured(frames, truth, beside, progress)->views.empty());
  for (Frame& frame : frames) MakeUnreadable(frame);
  const auto none = Measured(frames, truth, WallsOf(room), progress);
  ASSERT_TRUE(none.ok());
  EXPECT_TRUE(none->views.empty());
  EXPECT_FALSE(progress.warnings.empty());
}

}  // namespace
}  // namespace deepslam::mapping
