#include "deepslam/fuse/coarse_fusion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/core/parallel.h"
#include "deepslam/core/random.h"
#include "deepslam/geometry/depth_noise.h"
#include "support/box_world.h"

namespace deepslam::fuse {
namespace {

using testing_support::BoxWorldSource;
using testing_support::Cuboid;

// A wall at x = 2 with a window in it, and a crate before it; seen from a few places at x < 0.
std::vector<Cuboid> WallWithWindow() {
  return {{-1, {2, -2, 0}, {2.2, -0.5, 2.4}},
          {-1, {2, 0.5, 0}, {2.2, 2, 2.4}},
          {-1, {2, -0.5, 0}, {2.2, 0.5, 0.9}},
          {-1, {2, -0.5, 1.9}, {2.2, 0.5, 2.4}},
          {0, {1.0, -1.6, 0}, {1.6, -1.0, 0.6}}};
}

std::vector<Pose3> Places() {
  std::vector<Pose3> poses;
  for (const double y : {-0.8, -0.4, 0.0, 0.4, 0.8})
    poses.push_back(testing_support::LookAt({-1, y, 1.4}, {2, 0.2 * y, 1.0}));
  return poses;
}

CoarseSurface Fused(const std::vector<Cuboid>& world, const std::vector<Pose3>& poses) {
  const BoxWorldSource frames(world, poses);
  CoarseFusion fusion{CoarseOptions()};
  for (int n = 0; n < frames.num_frames(); ++n) {
    const FrameIdx frame{n};
    EXPECT_TRUE(fusion.Integrate(frames.View(frame).frame, frames.camera(), poses[n]).ok());
  }
  return std::move(fusion).Take();
}

TEST(CoarseFusion, HasTheSurfaceWithinAVoxelAndItsNormals) {
  const CoarseSurface surface = Fused(WallWithWindow(), Places());
  const std::size_t n = surface.mesh.vertices.size();
  ASSERT_GT(n, 1000U);
  ASSERT_EQ(surface.normals.size(), n);
  ASSERT_EQ(surface.num_frames.size(), n);
  EXPECT_EQ(surface.mesh.colours.size(), n);
  EXPECT_EQ(surface.viewpoints.size(), 5U);
  int num_on_wall = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3f& p = surface.mesh.vertices[i];
    EXPECT_GE(surface.num_frames[i], 1);
    EXPECT_LE(surface.num_frames[i], 5);
    // Well inside the wall's right half, above the crate.
    if (p.x() < 1.8F || p.y() > -0.7F || p.y() < -1.4F || p.z() < 1.0F || p.z() > 1.8F) continue;
    ++num_on_wall;
    EXPECT_NEAR(p.x(), 2.0, 0.5 * surface.voxel_m);
    EXPECT_LT(surface.normals[i].x(), -0.95F);
  }
  EXPECT_GT(num_on_wall, 200);
}

// From 15 degrees above, the band along the rays is 1.6 cm of height: a voxel's centre lies in it
// or not, as the top happens to lie.
TEST(CoarseFusion, HasTopsThatRaysGrazeAtAnyHeight) {
  for (const double top_m : {0.80, 0.81, 0.82, 0.83}) {
    const std::vector<Cuboid> dresser = {{0, {2.0, -0.8, 0}, {2.5, 0.8, top_m}}};
    std::vector<Pose3> poses;
    for (const double y : {-0.4, 0.0, 0.4})
      poses.push_back(testing_support::LookAt({0, y, top_m + 0.6}, {2.2, 0, top_m}));
    const CoarseSurface surface = Fused(dresser, poses);
    const auto is_top = [&](const Eigen::Vector3f& p) {
      return p.x() > 2.1F && p.x() < 2.4F && std::abs(p.y()) < 0.6F &&
             std::abs(static_cast<double>(p.z()) - top_m) < 0.5 * surface.voxel_m;
    };
    // 0.3 x 1.2 m of it in voxels of 3 cm.
    EXPECT_GT(std::ranges::count_if(surface.mesh.vertices, is_top), 320) << top_m;
  }
}

// Noise as a Kinect's times so much, each reading by itself.
CoarseSurface FusedNoisy(const std::vector<Cuboid>& world, const Pose3& pose, double times) {
  const std::vector<Pose3> poses(8, pose);
  const BoxWorldSource frames(world, poses);
  CoarseFusion fusion{CoarseOptions()};
  Random random(3, "noisy frames", 0);
  for (int n = 0; n < frames.num_frames(); ++n) {
    Frame frame = frames.View(FrameIdx{n}).frame;
    for (float& depth_m : frame.depth_m) {
      if (depth_m <= 0) continue;
      depth_m += static_cast<float>(times * DepthSigmaM(depth_m) * random.Normal());
    }
    EXPECT_TRUE(fusion.Integrate(frame, frames.camera(), pose).ok());
  }
  return std::move(fusion).Take();
}

// A wall at 4 m, whose layers would be taken for furniture, and a crate at 1.8 m.
TEST(CoarseFusion, ReachesLessFarTheNoisierTheDepthIs) {
  const std::vector<Cuboid> world = {{-1, {3.0, -2, 0}, {3.2, 2, 2.4}},
                                     {0, {0.8, -0.4, 0.8}, {1.4, 0.4, 1.4}}};
  const Pose3 pose = testing_support::LookAt({-1, 0, 1.2}, {2, 0, 1.2});
  const auto count = [](const CoarseSurface& surface, float from_x, float to_x) {
    return std::ranges::count_if(surface.mesh.vertices, [&](const Eigen::Vector3f& p) {
      return p.x() > from_x && p.x() < to_x;
    });
  };
  for (const double times : {0.0, 1.0}) {
    const CoarseSurface surface = FusedNoisy(world, pose, times);
    EXPECT_GT(count(surface, 2.5F, 3.5F), 1000) << times;
    EXPECT_GT(count(surface, 0.6F, 1.0F), 300) << times;
  }
  const CoarseSurface noisy = FusedNoisy(world, pose, 3);
  EXPECT_EQ(count(noisy, 2.8F, 4.5F), 0);
  EXPECT_GT(count(noisy, 0.6F, 1.0F), 300);
  EXPECT_GT(noisy.space.Passed({2.0, 1.0, 1.2}), 0);
}

TEST(CoarseFusion, TellsFreeFromUnseenFromBlind) {
  const CoarseSurface surface = Fused(WallWithWindow(), Places());
  const ObservedSpace& space = surface.space;
  EXPECT_GT(space.Passed({0.5, 0, 1.2}), 0);     // before the wall
  EXPECT_EQ(space.Passed({2.3, -1.2, 1.4}), 0);  // in and behind it
  EXPECT_EQ(space.Passed({2.6, -1.2, 1.4}), 0);
  EXPECT_EQ(space.Passed({1.3, -1.3, 0.3}), 0);  // in the crate
  EXPECT_GT(space.Passed({1.3, -1.3, 0.9}), 0);  // above it
  // Through the window the sky is seen, of which nothing was measured.
  EXPECT_EQ(space.Blind({2.1, 0, 1.6}), 5);
  EXPECT_EQ(space.Passed({2.1, 0, 1.6}), 0);
  EXPECT_EQ(space.Blind({0.5, -0.6, 0.5}), 0);
}

TEST(CoarseFusion, NothingOfASurfaceIsFree) {
  const CoarseSurface surface = Fused(WallWithWindow(), Places());
  for (std::size_t i = 0; i < surface.mesh.vertices.size(); ++i) {
    const Eigen::Vector3d behind =
        (surface.mesh.vertices[i] - 0.06F * surface.normals[i]).cast<double>();
    // Corners and edges have slanted normals; flat parts are what is asked.
    if (surface.normals[i].cwiseAbs().maxCoeff() < 0.999F || behind.z() < 0) continue;
    EXPECT_LE(surface.space.Passed(behind), 1) << behind.transpose();
  }
}

TEST(CoarseFusion, DoesNotDependOnTheNumberOfThreads) {
  const auto with_threads = [](int num_threads) {
    const ThreadLimit limit(num_threads);
    return Fused(WallWithWindow(), Places());
  };
  const CoarseSurface one = with_threads(1);
  const CoarseSurface four = with_threads(4);
  EXPECT_EQ(one.mesh.vertices, four.mesh.vertices);
  EXPECT_EQ(one.mesh.faces, four.mesh.faces);
  EXPECT_EQ(one.normals, four.normals);
  EXPECT_EQ(one.num_frames, four.num_frames);
  ASSERT_EQ(one.space.blocks().size(), four.space.blocks().size());
  for (std::size_t n = 0; n < one.space.blocks().size(); ++n) {
    EXPECT_EQ(one.space.blocks()[n].index, four.space.blocks()[n].index);
    EXPECT_EQ(one.space.blocks()[n].passed, four.space.blocks()[n].passed);
    EXPECT_EQ(one.space.blocks()[n].blind, four.space.blocks()[n].blind);
  }
}

TEST(CoarseFusion, GoesWithoutColour) {
  const BoxWorldSource frames(WallWithWindow(), Places());
  CoarseFusion fusion{CoarseOptions()};
  Frame depth_only = frames.View({0}).frame;
  depth_only.colour = ColourImage();
  ASSERT_TRUE(fusion.Integrate(depth_only, frames.camera(), Places()[0]).ok());
  const CoarseSurface surface = std::move(fusion).Take();
  EXPECT_GT(surface.mesh.vertices.size(), 500U);
  EXPECT_TRUE(surface.mesh.colours.empty());
}

TEST(CoarseFusion, RefusesBadFramesAndGoesOn) {
  const BoxWorldSource frames(WallWithWindow(), Places());
  const Frame good = frames.View({0}).frame;
  CoarseFusion fusion{CoarseOptions()};
  Frame small = good;
  small.depth_m = DepthImage(3, 3, 1.0F);
  EXPECT_EQ(fusion.Integrate(small, frames.camera(), {}).error().code, ErrorCode::kInvalidInput);
  Frame other_colour = good;
  other_colour.colour = ColourImage(3, 3, {});
  EXPECT_FALSE(fusion.Integrate(other_colour, frames.camera(), {}).ok());
  Pose3 nan;
  nan.translation_m.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(fusion.Integrate(good, frames.camera(), nan).ok());
  PinholeCamera flat = frames.camera();
  flat.fy = 0;
  EXPECT_FALSE(fusion.Integrate(good, flat, {}).ok());
  EXPECT_TRUE(fusion.Integrate(good, frames.camera(), Places()[0]).ok());
  EXPECT_FALSE(std::move(fusion).Take().mesh.empty());
}

TEST(CoarseFusion, SaysWhereTheSurfaceOutgrewItsBound) {
  const BoxWorldSource frames(WallWithWindow(), Places());
  CoarseOptions options;
  options.max_voxel_blocks = 2;
  CoarseFusion fusion(options);
  EXPECT_FALSE(fusion.surface_full());
  EXPECT_TRUE(fusion.Integrate(frames.View({0}).frame, frames.camera(), Places()[0]).ok());
  EXPECT_TRUE(fusion.surface_full());
  EXPECT_TRUE(std::move(fusion).Take().mesh.empty());
}

TEST(CoarseFusion, OfNothingIsEmpty) {
  const CoarseSurface surface = CoarseFusion(CoarseOptions()).Take();
  EXPECT_TRUE(surface.mesh.empty());
  EXPECT_TRUE(surface.space.empty());
  EXPECT_TRUE(surface.viewpoints.empty());
}

}  // namespace
}  // namespace deepslam::fuse
