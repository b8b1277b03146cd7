#include "deepslam/ground/floor_patches.h"

#include <cmath>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/core/random.h"

namespace deepslam::ground {
namespace {

const PinholeCamera kCamera{640, 480, 525, 525, 319.5, 239.5};
const Eigen::Vector3d kUp(0, -1, 0);  // of a level camera

// A level surface this far below the camera and ahead of it, seen with a Kinect's noise.
void AddLevel(double below_m, double ahead_m, double length_m, Random& random, GroundPoints& seen) {
  constexpr int kStepPx = 4;
  seen.step_px = kStepPx;
  for (int u = 0; u < kCamera.width; u += kStepPx) {
    for (int v = 0; v < kCamera.height; v += kStepPx) {
      const Eigen::Vector3d ray = kCamera.Ray(u, v);
      if (ray.y() <= 0) continue;
      const double z = below_m / ray.y();
      if (z < ahead_m || z > ahead_m + length_m || std::abs(ray.x() * z) > 0.5 * length_m) continue;
      GroundPoint point;
      point.sigma_m = 0.01F;
      point.p_camera = (ray * (z + 0.01 * random.Normal())).cast<float>();
      point.normal_camera = kUp.cast<float>();
      seen.points.push_back(point);
    }
  }
}

TEST(LowestPatch, IsTheFloorBehindATableHoweverSmall) {
  Random random(3, "patch", 0);
  GroundPoints seen;
  AddLevel(0.7, 0.9, 1.2, random, seen);
  const std::size_t of_table = seen.points.size();
  AddLevel(1.45, 3.3, 0.5, random, seen);
  ASSERT_LT(seen.points.size() - of_table, 0.15 * static_cast<double>(of_table));
  const std::optional<FloorPatch> patch = LowestPatch(seen, kCamera, kUp);
  ASSERT_TRUE(patch.has_value());
  EXPECT_NEAR(patch->below_camera_m, 1.45, 0.02);
  EXPECT_GT(patch->area_m2, GroundOptions::kMinArea_m2);
  EXPECT_LT(patch->area_m2, 0.4);
}

TEST(LowestPatch, IsNoStrayDepthBelow) {
  Random random(4, "patch", 0);
  GroundPoints seen;
  AddLevel(0.7, 0.9, 1.2, random, seen);
  for (int n = 0; n < 25; ++n) {
    seen.points.push_back(seen.points[static_cast<std::size_t>(n)]);
    seen.points.back().p_camera.y() = 2;
  }
  const std::optional<FloorPatch> patch = LowestPatch(seen, kCamera, kUp);
  ASSERT_TRUE(patch.has_value());
  EXPECT_NEAR(patch->below_camera_m, 0.7, 0.02);
}

TEST(LowestPatch, NeedsSomethingThatFacesUp) {
  EXPECT_FALSE(LowestPatch({}, kCamera, kUp).has_value());
  Random random(5, "patch", 0);
  GroundPoints seen;
  AddLevel(0.7, 0.9, 1.2, random, seen);
  EXPECT_FALSE(LowestPatch(seen, kCamera, Eigen::Vector3d(1, 0, 0)).has_value());
}

// Cameras 1.5 m above the floor see a seat, and some of them floor, a little off.
std::vector<FloorPatch> Patches(int num_of_floor, double camera_m = 1.5) {
  std::vector<FloorPatch> patches;
  for (int k = 0; k < 6; ++k) {
    const double height_m = k < num_of_floor ? 0.02 * (k % 3) : 0.45;
    patches.push_back(
        {static_cast<std::size_t>(k), height_m - camera_m, camera_m - height_m, 0.08, 200});
  }
  return patches;
}

std::vector<KeyframeSample> Samples(double share_below, double below_m) {
  KeyframeSample sample;
  for (int n = 0; n < 100; ++n) {
    const double z = n < 100 * share_below ? below_m : 0;
    sample.points_world.emplace_back(0.0F, 0.0F, static_cast<float>(z));
  }
  return {sample};
}

const Eigen::Vector3d kUpWorld(0, 0, 1);

TEST(FindLowestLevel, IsWhatSeveralKeyframesAgreeOn) {
  const std::optional<PatchLevel> level = FindLowestLevel(Patches(3), {}, kUpWorld, {});
  ASSERT_TRUE(level.has_value());
  EXPECT_EQ(level->patches, (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_NEAR(level->height_m, -1.48, 1e-9);
}

TEST(FindLowestLevel, OneKeyframeAloneSaysNothing) {
  const std::optional<PatchLevel> level = FindLowestLevel(Patches(1), {}, kUpWorld, {});
  ASSERT_TRUE(level.has_value());
  EXPECT_EQ(level->patches.size(), 5U) << "the seat";
}

TEST(FindLowestLevel, IsNoneWhereSomethingLiesBelow) {
  EXPECT_TRUE(FindLowestLevel(Patches(3), Samples(0.01, -2), kUpWorld, {}).has_value());
  EXPECT_FALSE(FindLowestLevel(Patches(3), Samples(0.1, -2), kUpWorld, {}).has_value());
}

TEST(FindLowestLevel, IsNoneSoNearOrSoFarBelowTheCameras) {
  EXPECT_FALSE(FindLowestLevel(Patches(3, 0.7), {}, kUpWorld, {}).has_value());
  EXPECT_FALSE(FindLowestLevel(Patches(3, 3.0), {}, kUpWorld, {}).has_value());
}

}  // namespace
}  // namespace deepslam::ground
