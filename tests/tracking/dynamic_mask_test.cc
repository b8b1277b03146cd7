#include "deepslam/tracking/dynamic_mask.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "alignment/box_world.h"
#include "deepslam/alignment/reference_pixels.h"

namespace deepslam::tracking {
namespace {

using alignment::AsReference;
using alignment::BuildPyramid;
using testing_support::Arc;
using testing_support::BoxWorld;
using testing_support::kSmallCamera;
using testing_support::RenderFrame;

PlacedPyramid Seen(const BoxWorld& world, const Pose3& world_from_camera, std::uint64_t seed = 0) {
  const Frame frame = RenderFrame(world, world_from_camera, 1.0, seed);
  return {std::make_shared<const FramePyramid>(AsReference(BuildPyramid(frame, kSmallCamera, {}))),
          world_from_camera};
}

std::vector<PlacedPyramid> Earlier(const BoxWorld& world) {
  std::vector<PlacedPyramid> earlier;
  for (const Pose3& pose : Arc(3, 3.0)) earlier.push_back(Seen(world, pose, earlier.size()));
  return earlier;
}

// A person, so to say, in the midst of the view.
const Box3 kPerson{{-0.75, -0.55, 0}, {-0.45, -0.15, 1.6}};

BoxWorld WithPerson() {
  BoxWorld world = BoxWorld::Furnished();
  world.boxes.push_back(kPerson);
  return world;
}

bool IsOnPerson(const Eigen::Vector3d& p_world) {
  return (p_world.array() > kPerson.min.array() - 0.05).all() &&
         (p_world.array() < kPerson.max.array() + 0.05).all();
}

// Of the pixels that show the person, and of the others, the share that is set.
struct Shares {
  double of_person = 0;
  double of_rest = 0;
};

Shares SharesOf(const Mask& mask, const PlacedPyramid& frame) {
  const PyramidLevel& level = FreeSpaceLevel(*frame.pyramid);
  int num_person = 0, num_rest = 0, set_person = 0, set_rest = 0;
  for (int v = 0; v < level.camera.height; ++v) {
    for (int u = 0; u < level.camera.width; ++u) {
      const auto z_m =
          static_cast<double>(level.depth_m[static_cast<std::size_t>(v * level.camera.width + u)]);
      if (!(z_m > 0)) continue;
      const bool on = IsOnPerson(frame.world_from_camera * (z_m * level.camera.Ray(u, v)));
      (on ? num_person : num_rest) += 1;
      (on ? set_person : set_rest) += mask(u, v);
    }
  }
  return {num_person > 0 ? static_cast<double>(set_person) / num_person : 0,
          num_rest > 0 ? static_cast<double>(set_rest) / num_rest : 0};
}

TEST(DynamicMask, IsWhoCameIntoTheView) {
  const PlacedPyramid frame = Seen(WithPerson(), Arc(3, 3.0)[1], 7);
  const Shares shares = SharesOf(DynamicMask(frame, Earlier(BoxWorld::Furnished()), {}), frame);
  EXPECT_GT(shares.of_person, 0.8);
  EXPECT_LT(shares.of_rest, 0.02);
}

TEST(DynamicMask, IsEmptyWhereNothingMovedOrWentAwayOrNobodyLooked) {
  const PlacedPyramid frame = Seen(BoxWorld::Furnished(), Arc(3, 3.0)[1], 7);
  const auto num_set = [&](const std::vector<PlacedPyramid>& earlier) {
    return std::ranges::count(DynamicMask(frame, earlier, {}), std::uint8_t{1});
  };
  EXPECT_EQ(num_set(Earlier(BoxWorld::Furnished())), 0);
  // What comes out from behind somebody has not moved.
  EXPECT_EQ(num_set(Earlier(WithPerson())), 0);
  EXPECT_EQ(num_set({}), 0);
}

// The latest that saw a place counts: who has stood there since is furniture.
TEST(DynamicMask, GoesByTheLatestObserver) {
  const PlacedPyramid frame = Seen(WithPerson(), Arc(3, 3.0)[1], 7);
  std::vector<PlacedPyramid> earlier = Earlier(BoxWorld::Furnished());
  earlier.push_back(Seen(WithPerson(), Arc(3, 3.0)[2], 8));
  EXPECT_LT(SharesOf(DynamicMask(frame, earlier, {}), frame).of_person, 0.1);
}

TEST(WithoutDynamic, HidesNothingButTheMaskAndItsOutlines) {
  const PlacedPyramid frame = Seen(WithPerson(), Arc(3, 3.0)[1], 7);
  const auto hidden = WithoutDynamic(frame, Earlier(BoxWorld::Furnished()), {});
  ASSERT_NE(hidden, frame.pyramid) << "nothing was hidden";
  ASSERT_EQ(hidden->levels.size(), frame.pyramid->levels.size());
  for (std::size_t n = 0; n < hidden->levels.size(); ++n) {
    const PyramidLevel& before = frame.pyramid->levels[n];
    const PyramidLevel& after = hidden->levels[n];
    const auto width = static_cast<std::size_t>(before.camera.width);
    double num_person = 0, num_rest = 0, hidden_person = 0, hidden_rest = 0;
    for (std::size_t k = 0; k < before.depth_m.size(); ++k) {
      if (!(before.depth_m[k] > 0)) continue;
      const Eigen::Vector3d ray =
          before.camera.Ray(static_cast<double>(k % width), static_cast<double>(k / width));
      const bool on =
          IsOnPerson(frame.world_from_camera * (static_cast<double>(before.depth_m[k]) * ray));
      (on ? num_person : num_rest) += 1;
      if (after.depth_m[k] == before.depth_m[k]) continue;
      EXPECT_EQ(after.depth_m[k], 0);
      EXPECT_EQ(after.surface[k].offset_m, 0);
      EXPECT_EQ(after.signed_depth_m[k], 0);
      (on ? hidden_person : hidden_rest) += 1;
    }
    EXPECT_GT(hidden_person, 0.8 * num_person);
    EXPECT_LT(hidden_rest, 0.3 * num_rest);
    EXPECT_EQ(after.intensity, before.intensity) << "images stay";
  }
}

TEST(WithoutDynamic, GivesTheSamePyramidBackWhereNextToNothingMoved) {
  const PlacedPyramid frame = Seen(BoxWorld::Furnished(), Arc(3, 3.0)[1], 7);
  EXPECT_EQ(WithoutDynamic(frame, Earlier(BoxWorld::Furnished()), {}), frame.pyramid);
  EXPECT_EQ(WithoutDynamic(frame, {}, {}), frame.pyramid);
}

}  // namespace
}  // namespace deepslam::tracking
