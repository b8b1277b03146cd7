#include "deepslam/alignment/rotation_search.h"

#include <cmath>

#include <gtest/gtest.h>

#include "alignment/box_world.h"
#include "deepslam/alignment/image_shift.h"

namespace deepslam::alignment {
namespace {

using testing_support::BoxWorld;
using testing_support::kRadPerDeg;
using testing_support::kSmallCamera;
using testing_support::LookAt;
using testing_support::RenderFrame;

FramePyramid Seen(const BoxWorld& world, const Pose3& world_from_camera) {
  return BuildPyramid(RenderFrame(world, world_from_camera, 1.0), kSmallCamera, {});
}

// A camera in a room that looks `pan_deg` aside.
Pose3 Turned(double pan_deg) {
  const double pan = pan_deg * kRadPerDeg;
  const Eigen::Vector3d eye(-1.2, -0.3, 1.4);
  return LookAt(eye, eye + Eigen::Vector3d(2 * std::cos(pan), 2 * std::sin(pan), -0.8));
}

TEST(SearchRotation, FindsTurnsThatNoPredictionKnows) {
  const FramePyramid i = Seen(BoxWorld::Furnished(), Turned(0));
  for (const double pan_deg : {-14.0, -5.0, 0.0, 9.0, 16.0}) {
    const auto found = SearchRotation(i, Seen(BoxWorld::Furnished(), Turned(pan_deg)));
    ASSERT_TRUE(found.has_value()) << pan_deg;
    const Eigen::Quaterniond truth = (Turned(0).Inverse() * Turned(pan_deg)).rotation;
    EXPECT_LT(RotationAngle(found->inverse() * truth), 1.5 * kRadPerDeg) << pan_deg;
  }
}

TEST(SearchRotation, FindsNothingWithoutTexture) {
  BoxWorld bare = BoxWorld::Furnished();
  bare.texture = 0;
  EXPECT_FALSE(SearchRotation(Seen(bare, Turned(0)), Seen(bare, Turned(5))).has_value());
  const FramePyramid good = Seen(BoxWorld::Furnished(), Turned(0));
  EXPECT_FALSE(SearchRotation(good, {}).has_value());
  EXPECT_FALSE(SearchRotation({}, good).has_value());
}

TEST(BestShift, IsTheOneThatAnImageWasShiftedBy) {
  const FramePyramid pyramid = Seen(BoxWorld::Furnished(), Turned(0));
  const PyramidLevel& level = pyramid.levels.back();
  PyramidLevel shifted = level;
  constexpr int kU = 3, kV = -2;
  for (int v = 0; v < level.camera.height; ++v) {
    for (int u = 0; u < level.camera.width; ++u) {
      const bool inside =
          u + kU >= 0 && u + kU < level.camera.width && v + kV >= 0 && v + kV < level.camera.height;
      shifted.intensity(u, v) = inside ? level.intensity(u + kU, v + kV) : 128.0F;
    }
  }
  const ImageShift shift = BestShift(level, shifted);
  EXPECT_EQ(shift.u, kU);
  EXPECT_EQ(shift.v, kV);
}

}  // namespace
}  // namespace deepslam::alignment
