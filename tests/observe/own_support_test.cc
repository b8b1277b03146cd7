#include "deepslam/observe/own_support.h"

#include <gmock/gmock.h>

#include "support/box_world.h"

namespace deepslam::observe {
namespace {

using namespace testing_support;  // NOLINT

constexpr Supports kFloorOnly = {};
constexpr Supports kFurniture = {.floor = false, .furniture = true};
constexpr Supports kEither = {.furniture = true};
constexpr Supports kFloorOrWall = {.wall = true};
constexpr Supports kWall = {.floor = false, .wall = true};

// Whole images of a box whose foot is so high above the floor.
std::vector<ObjectView> ViewsOf(double foot_m, int count = 3) {
  std::vector<ObjectView> views;
  for (int n = 0; n < count; ++n) {
    const Pose3 world_from_camera =
        LookAt({1.5 - 0.4 * n, -1.6, foot_m + 0.7}, {0, 0, foot_m + 0.2});
    const BoxView seen = RenderBoxes(
        {{0, {-0.3, -0.2, foot_m}, {0.3, 0.2, foot_m + 0.4}}}, SmallCamera(), world_from_camera);
    ObjectView view;
    view.camera = SmallCamera();
    view.depth_crop_m = seen.frame.depth_m;
    view.mask_crop = Mask(seen.object.width(), seen.object.height());
    for (int v = 0; v < seen.object.height(); ++v) {
      for (int u = 0; u < seen.object.width(); ++u)
        view.mask_crop(u, v) = seen.object(u, v) == 0 ? 1 : 0;
    }
    view.world_from_camera = world_from_camera;
    view.ground_camera = FloorIn(world_from_camera);
    views.push_back(std::move(view));
  }
  return views;
}

// Height above the floor of what the views take for ground, by each view.
std::vector<double> GroundHeights(const std::vector<ObjectView>& views) {
  std::vector<double> heights_m;
  for (const ObjectView& view : views)
    heights_m.push_back(-Transformed(view.world_from_camera, *view.ground_camera).d_m);
  return heights_m;
}

TEST(PutOnOwnSupport, TheGroundOfAThingOnFurnitureIsWhatItStandsOn) {
  constexpr double kTolerance_m = 0.02;  // 2 % of the points of a thing 0.4 m high, and a pixel
  for (const Supports& supports : {kFurniture, kEither, kWall}) {
    std::vector<ObjectView> views = ViewsOf(0.75);
    PutOnOwnSupport(supports, views);
    EXPECT_THAT(GroundHeights(views), testing::Each(testing::DoubleNear(0.75, kTolerance_m)));
    for (const ObjectView& view : views) {
      EXPECT_EQ(view.ground_camera->normal, FloorIn(view.world_from_camera).normal)
          << "it stays level";
    }
  }
}

TEST(PutOnOwnSupport, WhatStandsOnTheFloorStaysThere) {
  const auto stays = [](const Supports& supports, double foot_m) {
    std::vector<ObjectView> views = ViewsOf(foot_m);
    PutOnOwnSupport(supports, views);
    return std::ranges::all_of(views, [](const ObjectView& view) {
      return *view.ground_camera == FloorIn(view.world_from_camera);
    });
  };
  EXPECT_TRUE(stays(kFloorOnly, 0.75)) << "its feet are hidden";
  EXPECT_TRUE(stays(kEither, 0));
  EXPECT_TRUE(stays(kEither, 0.15)) << "something low stands before it";
  EXPECT_FALSE(stays(kEither, 0.45));
  EXPECT_TRUE(stays(kFloorOrWall, 0.45)) << "a bed stands before the cabinet";
  EXPECT_FALSE(stays(kFloorOrWall, 1.4)) << "a wall cabinet";
}

TEST(PutOnOwnSupport, BearsViewsThatSayNothing) {
  PutOnOwnSupport(kFurniture, {});
  std::vector<ObjectView> views = ViewsOf(0.75);
  for (ObjectView& view : views) view.mask_crop = Mask(320, 240);
  const std::vector<double> before = GroundHeights(views);
  PutOnOwnSupport(kFurniture, views);
  EXPECT_EQ(GroundHeights(views), before) << "nothing was measured";
  views = ViewsOf(0.75);
  views[1].ground_camera.reset();
  PutOnOwnSupport(kFurniture, views);
  EXPECT_FALSE(views[1].ground_camera.has_value());
  EXPECT_NEAR(-Transformed(views[0].world_from_camera, *views[0].ground_camera).d_m, 0.75, 0.02);
  std::vector<ObjectView> sunk = ViewsOf(-0.3);
  PutOnOwnSupport(kFurniture, sunk);
  EXPECT_THAT(GroundHeights(sunk), testing::Each(testing::DoubleNear(0, 0.02)))
      << "nothing stands below the floor";
}

}  // namespace
}  // namespace deepslam::observe
