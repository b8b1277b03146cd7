#include "deepslam/mesh/colour_mesh.h"

#include <limits>

#include <gtest/gtest.h>

#include "deepslam/mesh/extract_surface.h"
#include "support/voxel_shapes.h"

namespace deepslam::mesh {
namespace {

using namespace testing_support;  // NOLINT(google-build-using-namespace)

constexpr Rgb8 kRed{200, 20, 20};
constexpr Rgb8 kBlue{20, 20, 200};
constexpr Rgb8 kFallback{1, 2, 3};

// A box of 1 m x 0.5 m x 0.5 m (about), seen from +y at 2 m: its half with x > 0 is red, the other
// blue.
TriangleMesh MetricBox() { return *ExtractSurface(Box(30, 15, 15), {}); }

ObjectView ViewFromPlusY() {
  ObjectView view;
  view.camera = {320, 240, 300, 300, 159.5, 119.5};
  // Camera at (0, 2, 0) looking along -y with z of the world up: x right is -x of the world.
  Eigen::Matrix3d world_from_camera;
  world_from_camera << -1, 0, 0, 0, 0, -1, 0, -1, 0;
  view.world_from_camera = {Eigen::Quaterniond(world_from_camera), {0, 2, 0}};
  view.depth_crop_m = DepthImage(320, 240, 0.0F);
  view.colour_crop = ColourImage(320, 240);
  view.mask_crop = Mask(320, 240, 0);
  const double front_m = 2.0 - 15 * kVoxelSize;
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) {
      const Eigen::Vector3d p = view.camera.Unproject(u, v, front_m);
      if (std::abs(p.x()) > 30 * kVoxelSize || std::abs(p.y()) > 15 * kVoxelSize) continue;
      view.depth_crop_m(u, v) = static_cast<float>(front_m);
      view.colour_crop(u, v) = p.x() < 8 * kVoxelSize ? kRed : kBlue;
      view.mask_crop(u, v) = 1;
    }
  }
  return view;
}

TEST(ColourMesh, GivesSeenVerticesTheColourOfTheirPixel) {
  const std::vector<ObjectView> views = {ViewFromPlusY()};
  ColourReport report;
  const TriangleMesh mesh = ColourMesh(MetricBox(), views, {}, kFallback, {}, &report);
  ASSERT_EQ(mesh.colours.size(), mesh.vertices.size());
  EXPECT_GT(report.num_seen, 500);
  for (std::size_t n = 0; n < mesh.vertices.size(); ++n) {
    const Eigen::Vector3f p = mesh.vertices[n] / static_cast<float>(kVoxelSize);
    if (p.y() < 14.9F || std::abs(p.x() + 8) < 2 || std::abs(p.x()) > 27 || std::abs(p.z()) > 12)
      continue;
    EXPECT_EQ(mesh.colours[n], p.x() > -8 ? kRed : kBlue) << p.transpose();
  }
}

TEST(ColourMesh, TakesNoColourFromWhatStandsInFront) {
  ObjectView view = ViewFromPlusY();
  for (float& depth : view.depth_crop_m) depth *= 0.5F;
  ColourReport report;
  const std::vector<ObjectView> views = {view};
  const TriangleMesh mesh = ColourMesh(MetricBox(), views, {}, kFallback, {}, &report);
  EXPECT_EQ(report.num_seen, 0);
  for (const Rgb8 colour : mesh.colours) EXPECT_EQ(colour, kFallback);
}

TEST(ColourMesh, OutvotesOneWrongView) {
  std::vector<ObjectView> views(3, ViewFromPlusY());
  for (Rgb8& colour : views[1].colour_crop) colour = {255, 255, 255};
  const TriangleMesh mesh = ColourMesh(MetricBox(), views, {}, kFallback);
  for (const Rgb8 colour : mesh.colours) EXPECT_LT(colour.g, 200);
}

TEST(ColourMesh, FollowsTheObjectsPose) {
  // Turned by half a turn about z with the view's world turned alike: the same picture.
  const Pose3 turn{Eigen::Quaterniond(Eigen::AngleAxisd(1.1, Eigen::Vector3d::UnitZ())),
                   {3, -1, 2}};
  ObjectView view = ViewFromPlusY();
  const std::vector<ObjectView> plain = {view};
  view.world_from_camera = turn * view.world_from_camera;
  const std::vector<ObjectView> moved = {view};
  const TriangleMesh a = ColourMesh(MetricBox(), plain, {}, kFallback);
  const TriangleMesh b = ColourMesh(MetricBox(), moved, turn, kFallback);
  std::size_t num_different = 0;
  for (std::size_t n = 0; n < a.colours.size(); ++n)
    num_different += a.colours[n] == b.colours[n] ? 0 : 1;
  EXPECT_LT(num_different, a.colours.size() / 50);  // pixels rounded the other way
}

TEST(ColourMesh, LivesWithoutViewsAndWithBrokenOnes) {
  EXPECT_EQ(ColourMesh(MetricBox(), {}, {}, kFallback).colours.front(), kFallback);
  ObjectView empty;
  ObjectView sizes = ViewFromPlusY();
  sizes.colour_crop = ColourImage(3, 3);
  ObjectView nan = ViewFromPlusY();
  nan.world_from_camera.translation_m.x() = std::numeric_limits<double>::quiet_NaN();
  const std::vector<ObjectView> views = {empty, sizes, nan};
  ColourReport report;
  EXPECT_EQ(ColourMesh(MetricBox(), views, {}, kFallback, {}, &report).colours.front(), kFallback);
  EXPECT_EQ(report.num_seen, 0);
  EXPECT_TRUE(ColourMesh(TriangleMesh(), views, {}, kFallback).colours.empty());
}

}  // namespace
}  // namespace deepslam::mesh
