// Frames that are placed rightly show the same details, wrongly placed ones do not.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Core>

#include "alignment/box_world.h"
#include "alignment/rendered_pyramids.h"
#include "deepslam/alignment/patch_zncc.h"

namespace deepslam::alignment {
namespace {

using ::testing::Gt;
using ::testing::Lt;
using testing_support::Arc;
using testing_support::BoxWorld;
using testing_support::kRadPerDeg;
using testing_support::kSmallCamera;
using testing_support::LookAt;
using testing_support::RenderFrame;
using testing_support::Seen;

double DetailsInCommon(const BoxWorld& a, const BoxWorld& b, const std::array<Pose3, 2>& poses) {
  return PatchZncc(*Seen(a, poses[0], 1), *Seen(b, poses[1], 2), poses[0].Inverse() * poses[1], {});
}

TEST(PatchZncc, IsHighFromAnotherSideAndTheSameBothWays) {
  const BoxWorld world = BoxWorld::Furnished();
  const std::array<Pose3, 2> poses{Arc(2, 15.0)[0], Arc(2, 15.0)[1]};
  EXPECT_THAT(DetailsInCommon(world, world, poses), Gt(0.9));
  EXPECT_NEAR(DetailsInCommon(world, world, poses),
              DetailsInCommon(world, world, {poses[1], poses[0]}),
              0.02);
}

// Correlation of two images as they are.
double CorrelationOfImages(const BoxWorld& a, const BoxWorld& b, const Pose3& pose) {
  const IntensityImage in_a = Seen(a, pose, 1)->levels.front().intensity;
  const IntensityImage in_b = Seen(b, pose, 2)->levels.front().intensity;
  Eigen::ArrayXd values_a(in_a.size()), values_b(in_b.size());
  for (std::size_t k = 0; k < in_a.size(); ++k) {
    values_a[static_cast<Eigen::Index>(k)] = static_cast<double>(in_a.data()[k]);
    values_b[static_cast<Eigen::Index>(k)] = static_cast<double>(in_b.data()[k]);
  }
  values_a -= values_a.mean();
  values_b -= values_b.mean();
  return (values_a * values_b).mean() /
         std::sqrt(values_a.square().mean() * values_b.square().mean());
}

TEST(PatchZncc, SeesOtherPatternsBehindOneContrast) {
  BoxWorld here = BoxWorld::Furnished();
  here.boxes.clear();
  here.floor_darker = 80;
  here.texture = 0.4;
  BoxWorld there = here;
  there.texture_phase = 2.1;
  const Pose3 pose = Arc(1).front();
  EXPECT_THAT(CorrelationOfImages(here, there, pose), Gt(0.8));
  EXPECT_THAT(DetailsInCommon(here, here, {pose, pose}), Gt(0.9));
  EXPECT_THAT(DetailsInCommon(here, there, {pose, pose}),
              Lt(CorrelationOfImages(here, there, pose) - 0.15));
}

// A fifth of the view, in strong colours, is the same.
TEST(PatchZncc, IsNotOutvotedByOneThingThatStandsInBothPlaces) {
  BoxWorld here = BoxWorld::Furnished();
  here.texture = 0.25;
  BoxWorld there = here;
  there.texture_phase = 1.3;
  const Pose3 pose = Arc(1).front();
  const Frame thing = RenderFrame(BoxWorld::Furnished(), pose);
  const auto with_thing = [&](const BoxWorld& world) {
    Frame frame = RenderFrame(world, pose);
    const int end = frame.colour.height() / 5;
    std::copy(thing.colour.row(0), thing.colour.row(end), frame.colour.row(0));
    return BuildPyramid(frame, kSmallCamera, {});
  };
  EXPECT_THAT(PatchZncc(with_thing(here), with_thing(here), Pose3{}, {}), Gt(0.9));
  EXPECT_THAT(PatchZncc(with_thing(here), with_thing(there), Pose3{}, {}), Lt(0.6));
}

TEST(PatchZncc, SaysNothingWithoutDetailsOrColour) {
  BoxWorld bare = BoxWorld::Furnished();
  bare.texture = 0;
  const std::array<Pose3, 2> poses{Arc(1).front(), Arc(1).front()};
  EXPECT_EQ(DetailsInCommon(bare, bare, poses), 1);
  // One that shows details does not look like one that shows none.
  EXPECT_THAT(DetailsInCommon(bare, BoxWorld::Furnished(), poses), Lt(0.3));
  Frame depth_alone = RenderFrame(bare, poses[0]);
  depth_alone.colour = ColourImage();
  const FramePyramid pyramid = BuildPyramid(depth_alone, kSmallCamera, {});
  EXPECT_EQ(PatchZncc(pyramid, pyramid, Pose3{}, {}), 1);
}

}  // namespace
}  // namespace deepslam::alignment
