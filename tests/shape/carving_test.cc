#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "deepslam/shape/depth_view.h"
#include "deepslam/shape/small_components.h"
#include "deepslam/shape/stand.h"

namespace deepslam::shape {
namespace {

void Fill(const Eigen::Vector3i& low, const Eigen::Vector3i& high, VoxelGrid& grid) {
  for (int i = low.x(); i <= high.x(); ++i) {
    for (int j = low.y(); j <= high.y(); ++j) {
      for (int k = low.z(); k <= high.z(); ++k) grid.occupied[VoxelGrid::Index(i, j, k)] = 1;
    }
  }
}

TEST(SmallComponentsTest, PartsGoByTheirSizeAndWhatIsNearHangsTogether) {
  VoxelGrid grid;
  Fill({10, 10, 10}, {19, 19, 19}, grid);  // 1,000
  Fill({21, 21, 21}, {21, 21, 21}, grid);  // beyond a gap of one, over the corner
  Fill({40, 10, 10}, {40, 14, 13}, grid);  // 20, loose
  Fill({63, 63, 63}, {63, 63, 63}, grid);
  VoxelGrid with_neighbour = grid;
  with_neighbour.occupied[VoxelGrid::Index(63, 63, 63)] = 0;
  EXPECT_EQ(WithoutSmallComponents(grid, 2, 0.01), with_neighbour);
  VoxelGrid block;
  Fill({10, 10, 10}, {19, 19, 19}, block);
  EXPECT_EQ(WithoutSmallComponents(grid, 1, 0.05), block);
  EXPECT_EQ(WithoutSmallComponents(grid, 1, 0), grid);
  EXPECT_EQ(WithoutSmallComponents(VoxelGrid(), 1, 0.05), VoxelGrid());
}

TEST(StandOnGroundTest, OnlyWhatHangsLowReachesDown) {
  constexpr int kGround = 4;
  constexpr int kMaxGap = 5;
  VoxelGrid grid;
  Fill({10, 20, kGround + kMaxGap}, {10, 20, 40}, grid);      // a leg without its foot
  Fill({20, 20, kGround + kMaxGap + 1}, {20, 20, 40}, grid);  // an arm rest
  StandOnGround(kGround, kMaxGap, grid);
  VoxelGrid expected;
  Fill({10, 20, kGround}, {10, 20, 40}, expected);
  Fill({20, 20, kGround + kMaxGap + 1}, {20, 20, 40}, expected);
  EXPECT_EQ(grid, expected);
}

TEST(StandOnGroundTest, AGroundOutsideTheGridIsItsEdge) {
  VoxelGrid grid;
  Fill({10, 20, 2}, {10, 20, 5}, grid);
  Fill({12, 20, 60}, {12, 20, 61}, grid);
  VoxelGrid down = grid;
  StandOnGround(-100, 3, down);
  EXPECT_TRUE(down.At(10, 20, 0));
  EXPECT_FALSE(down.At(12, 20, 59));
  VoxelGrid up = grid;
  StandOnGround(1000, 3, up);
  EXPECT_EQ(up, grid);
}

// A wall 2 m before a camera that looks along z, 100 px wide, the right half of it the object.
ObjectView Wall(double slope) {
  ObjectView view;
  view.camera = {100, 100, 100, 100, 49.5, 49.5};
  view.depth_crop_m = DepthImage(100, 100);
  view.mask_crop = Mask(100, 100);
  for (int v = 0; v < 100; ++v) {
    for (int u = 0; u < 100; ++u) {
      const double x_by_z = (u - 49.5) / 100;
      view.depth_crop_m(u, v) = static_cast<float>(2 / (1 - slope * x_by_z));
      view.mask_crop(u, v) = u >= 50 ? 1 : 0;
    }
  }
  return view;
}

TEST(DepthViewTest, TellsPointAndMeasurement) {
  const ObjectView view = Wall(0);
  Pose3 camera_from_frame;
  camera_from_frame.translation_m = {0, 0, 1.5};
  const DepthView depth(view, camera_from_frame);
  const auto right = depth.At({0.2F, 0, 0.3F});
  ASSERT_TRUE(right);
  EXPECT_FLOAT_EQ(right->z_m, 1.8F);
  EXPECT_FLOAT_EQ(right->depth_m, 2);
  EXPECT_NEAR(right->cosine, 1 / std::hypot(1, 0.2 / 1.8), 1e-3) << "of the ray, not of the axis";
  EXPECT_TRUE(right->is_object);
  ASSERT_TRUE(depth.At({-0.2F, 0, 0.3F}));
  EXPECT_FALSE(depth.At({-0.2F, 0, 0.3F})->is_object);
  EXPECT_FALSE(depth.At({0, 0, -1.5F})) << "in the camera";
  EXPECT_FALSE(depth.At({0, 0, -3})) << "behind it";
  EXPECT_FALSE(depth.At({1, 0, 0.3F})) << "beside the image";
}

TEST(DepthViewTest, SlantedSurfacesAndMissingDepth) {
  ObjectView view = Wall(1);  // turned by 45 degrees
  view.depth_crop_m(50, 50) = 0;
  view.depth_crop_m(70, 50) = std::numeric_limits<float>::infinity();
  const DepthView depth(view, Pose3());
  const auto beside = depth.At({0.2F, 0.2F, 2});
  ASSERT_TRUE(beside);
  const Eigen::Vector3d normal = Eigen::Vector3d(-1, 0, 1).normalized();
  const Eigen::Vector3d ray = view.camera.Ray(60, 60).normalized();
  EXPECT_NEAR(beside->cosine, std::abs(normal.dot(ray)), 0.02);
  EXPECT_FALSE(depth.At({0.01F, 0.01F, 2})) << "nothing was measured there";
  EXPECT_FALSE(depth.At({0.41F, 0.01F, 2})) << "no distance";
}

TEST(DepthViewTest, PointsTogetherReadAsEachAlone) {
  ObjectView view = Wall(0.7);
  for (int v = 0; v < 100; v += 3) view.depth_crop_m(v, v) = 0;
  view.depth_crop_m(70, 50) = std::numeric_limits<float>::infinity();
  Pose3 camera_from_frame;
  camera_from_frame.translation_m = {0, 0, 0.5};
  const DepthView depth(view, camera_from_frame);
  VectorColumns points;
  for (std::size_t n = 0; n < kPointBatch; ++n) {
    const auto turn = static_cast<float>(n);
    points.Set(n, 0.8F * std::sin(turn), 0.8F * std::cos(3 * turn), 0.02F * turn - 0.6F);
  }
  DepthView::ReadingColumns readings;
  depth.At(points, kPointBatch, readings);
  int num_read = 0;
  for (std::size_t n = 0; n < kPointBatch; ++n) {
    const auto alone = depth.At({points.x[n], points.y[n], points.z[n]});
    EXPECT_EQ(readings.depth_m[n], alone ? alone->depth_m : 0.0F);
    if (!alone) continue;
    ++num_read;
    EXPECT_EQ(readings.z_m[n], alone->z_m);
    EXPECT_EQ(readings.cosine[n], alone->cosine);
    EXPECT_EQ(readings.is_object[n], alone->is_object ? 1 : 0);
  }
  EXPECT_GT(num_read, 30);
  EXPECT_LT(num_read, static_cast<int>(kPointBatch) - 30);
}

}  // namespace
}  // namespace deepslam::shape
