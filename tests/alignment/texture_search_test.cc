// A camera before a bare wall with a grain of one or two grey levels, moved along the wall.
#include "deepslam/alignment/weak_direction_search.h"

#include <cmath>
#include <cstdint>
#include <optional>

#include <gtest/gtest.h>

#include "alignment/box_world.h"

namespace deepslam::alignment {
namespace {

using testing_support::BoxWorld;
using testing_support::kRadPerDeg;

constexpr double kWall_m = 2;  // BoxWorld::Wall
constexpr PinholeCamera kCamera{640, 480, 524, 524, 319.5, 239.5};

FramePyramid Seen(const BoxWorld& world, const Pose3& world_from_camera, std::uint64_t seed) {
  return BuildPyramid(
      testing_support::RenderFrame(world, world_from_camera, 1.0, seed, kCamera), kCamera, {});
}

BoxWorld Grained() {
  BoxWorld world = BoxWorld::Wall();
  world.texture = 0;
  world.grain_greys = 2;
  return world;
}

// Of points of the wall, as the first camera sees it: two translations and the roll are not seen.
DegenerateDirections AlongTheWall() {
  Matrix6d hessian = Matrix6d::Zero();
  for (double x = -1; x <= 1; x += 0.2) {
    for (double y = -1; y <= 1; y += 0.2) {
      Vector6d row;
      row << 0, 0, -1, Eigen::Vector3d(x, y, kWall_m).cross(-Eigen::Vector3d::UnitZ());
      hessian += row * row.transpose();
    }
  }
  return DegenerateDirections(hessian);
}

Pose3 Moved(double x_m, double y_m, double roll_deg) {
  return {RotationFromVector(roll_deg * kRadPerDeg * Eigen::Vector3d::UnitZ()), {x_m, y_m, 0}};
}

const FirstStart kAsBefore{{}, {0.15, 0.1}};

std::optional<TexturePlace> Search(const BoxWorld& world, const Pose3& truth, const Pose3& end) {
  return SearchTexture(
      Seen(world, Pose3(), 1), Seen(world, truth, 2), AlongTheWall(), kAsBefore, end, {});
}

TEST(SearchTexture, FindsTheMotionAlongAGrainedWall) {
  for (const Pose3& truth : {Moved(0.15, -0.06, 0), Moved(-0.1, 0.1, 4), Moved(0.05, 0.2, -5)}) {
    const auto place = Search(Grained(), truth, Pose3());
    ASSERT_TRUE(place.has_value()) << truth.translation_m.transpose();
    EXPECT_FALSE(place->is_end);
    const Pose3 off = truth.Inverse() * place->i_from_j;
    // A pixel of the finest level is 8 mm at the wall.
    EXPECT_LT(off.translation_m.norm(), 0.01);
    EXPECT_LT(RotationAngle(off.rotation), 0.5 * kRadPerDeg);
    EXPECT_LT(place->sigma.translation_m, 0.01);
  }
}

TEST(SearchTexture, LeavesAnEndThatTextureConfirms) {
  const Pose3 truth = Moved(0.15, -0.06, 2);
  const auto place = Search(Grained(), truth, truth);
  ASSERT_TRUE(place.has_value());
  EXPECT_TRUE(place->is_end);
  EXPECT_EQ(place->i_from_j.translation_m, truth.translation_m);
}

TEST(SearchTexture, SaysNothingOfAWallWithoutTexture) {
  BoxWorld bare = BoxWorld::Wall();
  bare.texture = 0;
  EXPECT_FALSE(Search(bare, Moved(0.15, -0.06, 0), Pose3()).has_value());
}

TEST(SearchTexture, SaysNothingWhereTextureRepeatsItself) {
  // Stripes: along them every place is alike.
  const auto striped = [](double shift_px) {
    FramePyramid pyramid = Seen(BoxWorld::Wall(), Pose3(), 1);
    double scale = 1;
    for (PyramidLevel& level : pyramid.levels) {
      for (int v = 0; v < level.intensity.height(); ++v) {
        for (int u = 0; u < level.intensity.width(); ++u)
          level.intensity(u, v) =
              static_cast<float>(128 + 2 * std::sin((scale * u + shift_px) * 0.4));
      }
      scale *= 2;
    }
    return pyramid;
  };
  EXPECT_FALSE(
      SearchTexture(striped(0), striped(9.8), AlongTheWall(), kAsBefore, Pose3(), {}).has_value());
}

// Dirt on the lens, blocks of JPEG files: alike in both images, wherever the camera is.
TEST(SearchTexture, DoesNotFollowWhatTheCameraBringsAlong) {
  const FramePyramid pyramid = Seen(Grained(), Pose3(), 1);
  EXPECT_FALSE(SearchTexture(pyramid, pyramid, AlongTheWall(), kAsBefore, Moved(0.12, 0.06, 0), {})
                   .has_value());
}

TEST(SearchTexture, NeedsColourAndDirectionsThatDepthDoesNotShow) {
  const FramePyramid with = Seen(Grained(), Pose3(), 1);
  FramePyramid without = with;
  for (PyramidLevel& level : without.levels) level.intensity = {};
  const Pose3 end = Moved(0.1, 0, 0);
  EXPECT_FALSE(SearchTexture(with, without, AlongTheWall(), kAsBefore, end, {}).has_value());
  EXPECT_FALSE(SearchTexture(without, with, AlongTheWall(), kAsBefore, end, {}).has_value());
  EXPECT_FALSE(SearchTexture({}, with, AlongTheWall(), kAsBefore, end, {}).has_value());
  EXPECT_FALSE(SearchTexture(with, with, {}, kAsBefore, end, {}).has_value());
  AlignmentOptions by_depth;
  by_depth.photometric = false;
  EXPECT_FALSE(SearchTexture(with, with, AlongTheWall(), kAsBefore, end, by_depth).has_value());
}

}  // namespace
}  // namespace deepslam::alignment
