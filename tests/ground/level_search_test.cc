#include "deepslam/ground/level_search.h"

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/core/random.h"

namespace deepslam::ground {
namespace {

constexpr double kFloorBelow_m = 1.4;  // first camera, z up
constexpr double kTableBelow_m = 0.65;
constexpr double kCeilingAbove_m = 1.1;

// Keyframes that each see some of floor, table and ceiling a little off, and a wall now and then.
std::vector<PlaneSighting> Sightings(std::size_t num_keyframes) {
  Random random(11, "levels", 0);
  std::vector<PlaneSighting> sightings;
  const auto see = [&](std::size_t keyframe, double height_m, double share) {
    const Eigen::Vector3d tilt(random.Uniform(-0.02, 0.02), random.Uniform(-0.02, 0.02), 1);
    PlaneSighting seen;
    seen.keyframe = keyframe;
    const double own_m = height_m + random.Uniform(-0.03, 0.03);
    seen.plane_world = {tilt.normalized(), -own_m};
    seen.plane_camera = seen.plane_world;
    seen.centroid_world = {random.Uniform(-2, 2), random.Uniform(-2, 2), own_m};
    seen.camera_height_m = -own_m;
    seen.share = share * random.Uniform(0.5, 1);
    sightings.push_back(seen);
  };
  for (std::size_t k = 0; k < num_keyframes; ++k) {
    see(k, -kTableBelow_m, 0.3);  // the table fills more of the pictures
    if (k % 2 == 0) see(k, -kFloorBelow_m, 0.2);
    if (k % 5 == 0) see(k, kCeilingAbove_m, 0.1);
    if (k % 7 == 0) {
      see(k, 0, 0.3);
      sightings.back().plane_world.normal = {1, 0, 0};
    }
  }
  return sightings;
}

class LevelsOfSoManyKeyframes : public ::testing::TestWithParam<std::size_t> {};

// Also of paths of which not every sighting is voted on.
TEST_P(LevelsOfSoManyKeyframes, TheFloorIsTheLowestThatHolds) {
  const std::vector<PlaneSighting> sightings = Sightings(GetParam());
  const std::optional<std::size_t> ground = FindGroundSighting(sightings, {}, {});
  ASSERT_TRUE(ground.has_value());
  EXPECT_NEAR(sightings[*ground].centroid_world.z(), -kFloorBelow_m, 0.031);
  for (const PlaneSighting& other : sightings) {
    if (std::abs(other.centroid_world.z() + kFloorBelow_m) < 0.031) {
      EXPECT_LE(other.share, sightings[*ground].share) << "the largest of the level";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Keyframes,
                         LevelsOfSoManyKeyframes,
                         ::testing::Values(3, 50, 2000, 60'000));

TEST(LevelSearch, OfNothingThereIsNoGround) {
  EXPECT_FALSE(FindGroundSighting({}, {}, {}).has_value());
}

}  // namespace
}  // namespace deepslam::ground
