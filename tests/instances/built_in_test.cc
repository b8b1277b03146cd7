#include "deepslam/instances/built_in.h"

#include <vector>

#include <gmock/gmock.h>

#include "instances/sampled_world.h"

namespace deepslam::instances {
namespace {

using testing::SizeIs;

// What is mapped of a row of kitchen cabinets that ends at these places, with a basin let into its
// middle, which detections name.
std::vector<Instance> MappedRow(double begin_m, double end_m, bool is_built_in) {
  const std::vector<Cuboid> world = {{0, {begin_m, -0.3, 0}, {end_m, 0.3, 0.88}},
                                     {1, {-0.3, -0.25, 0.88}, {0.3, 0.25, 1.02}}};
  ClassTable classes = Classes();
  classes.classes.push_back({"sink", {"sink"}, {}, 0.3, 1.5, 0.1, 1.2, {}, {}});
  classes.classes.back().traits.built_in = is_built_in;
  const std::vector<Pose3> poses = Orbit({0, 0, 0.4}, 2.4, 1.7, 0, 40, 9);
  return Mapped(Find(world, poses, {{1, "sink"}}, Evidence::kMasks, {}, classes));
}

TEST(BuiltIn, ASinkCutsARowOfCabinetsAndTakesThePieceUnderIt) {
  const std::vector<Instance> mapped = MappedRow(-1.2, 0.8, true);
  ASSERT_THAT(mapped, SizeIs(3));
  EXPECT_EQ(CountClass(mapped, "sink"), 1);
  EXPECT_EQ(CountClass(mapped, "cabinet"), 2);
  for (const Instance& instance : mapped) {
    const UprightBox& box = instance.box_level;
    const bool is_sink = instance.class_name == "sink";
    EXPECT_NEAR(box.long_side_m(), is_sink || box.centre_m.x() > 0 ? 0.6 : 0.9, 0.08);
    EXPECT_LT(box.bottom_m, 0.05);
    EXPECT_NEAR(box.top_m, is_sink ? 1.02 : 0.88, 0.03);
  }
  EXPECT_THAT(MappedRow(-1.2, 0.8, false), SizeIs(2)) << "of a class that is never built in";
}

TEST(BuiltIn, WhatIsHardlyLongerThanItsBasinIsOneThingWithIt) {
  const std::vector<Instance> mapped = MappedRow(-0.5, 0.45, true);
  ASSERT_THAT(mapped, SizeIs(1));
  EXPECT_EQ(mapped[0].class_name, "sink");
  EXPECT_NEAR(mapped[0].box_level.long_side_m(), 0.95, 0.05);
}

}  // namespace
}  // namespace deepslam::instances
