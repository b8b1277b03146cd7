#include "deepslam/eval/held_out.h"

#include <gtest/gtest.h>

#include "support/box_meshes.h"

namespace deepslam::eval {
namespace {

// A box of 1 m, its front 2 m before the camera, and a depth image of one value.
HeldOutAgreement Judge(float depth_m) {
  const PinholeCamera camera{80, 60, 60, 60, 39.5, 29.5};
  return ScoreHeldOut(testing_support::BoxMesh({1, 1, 1}),
                      {Eigen::Quaterniond::Identity(), {0, 0, 2.5}},
                      camera,
                      DepthImage(80, 60, depth_m));
}

TEST(HeldOut, DepthOnTheModelAgrees) {
  EXPECT_EQ(Judge(2.0F).agreement(), 1);
  EXPECT_EQ(Judge(2.019F).agreement(), 1);
  EXPECT_GT(Judge(2.0F).num_agree, 700);  // 30 x 30 pixels, less rims
}

TEST(HeldOut, RaysThroughTheModelContradictAndNearerThingsSayNothing) {
  EXPECT_EQ(Judge(2.03F).agreement(), 0);
  EXPECT_EQ(Judge(2.03F).num_violated, Judge(2.0F).num_agree);
  EXPECT_EQ(Judge(1.9F).num_judged(), 0);
  EXPECT_EQ(Judge(1.9F).num_hidden, Judge(2.0F).num_agree);
}

TEST(HeldOut, HolesSayNothing) {
  const HeldOutAgreement nothing = Judge(0);
  EXPECT_EQ(nothing.num_judged() + nothing.num_hidden, 0);
  EXPECT_EQ(nothing.agreement(), 0);
}

VoxelGrid Cube(double side) {
  VoxelGrid grid;
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        const bool inside = VoxelGrid::Center(i, j, k).cwiseAbs().maxCoeff() < 0.5 * side;
        grid.occupied[VoxelGrid::Index(i, j, k)] = inside ? 1 : 0;
      }
    }
  }
  return grid;
}

// A cube of half a metre, its front 2 m before the camera; the mask is the 11 x 11 middle pixels.
MeasuredShare Measure(const DepthImage& depth_m) {
  const PinholeCamera camera{80, 60, 60, 60, 39.5, 29.5};
  const shape::ShapeModel model(Cube(0.5));
  Mask mask(80, 60);
  for (int v = 25; v <= 35; ++v) {
    for (int u = 35; u <= 45; ++u) mask(u, v) = 1;
  }
  const Similarity3 camera_from_object{1.0, Eigen::Quaterniond::Identity(), {0, 0, 2.25}};
  return ScoreMeasured(model, camera_from_object, camera, depth_m, mask);
}

TEST(HeldOut, DepthOfTheObjectIsNearTheModelOrNot) {
  EXPECT_EQ(Measure(DepthImage(80, 60, 2.0F)).num_measured, 121);
  EXPECT_EQ(Measure(DepthImage(80, 60, 2.0F)).share(), 1);
  EXPECT_EQ(Measure(DepthImage(80, 60, 2.019F)).share(), 1);
  EXPECT_EQ(Measure(DepthImage(80, 60, 1.97F)).share(), 0);
  EXPECT_EQ(Measure(DepthImage(80, 60, 2.25F)).share(), 0)
      << "the middle of a solid is not its surface";
}

TEST(HeldOut, OnlyWhatWasMeasuredOfTheObjectCounts) {
  DepthImage depth_m(80, 60, 2.0F);
  for (int u = 0; u < 80; ++u) depth_m(u, 30) = 0;     // a hole
  for (int u = 0; u < 80; ++u) depth_m(u, 10) = 5.0F;  // beside the object
  EXPECT_EQ(Measure(depth_m).num_measured, 110);
  EXPECT_EQ(Measure(depth_m).share(), 1);
  EXPECT_EQ(MeasuredShare().share(), 0);
}

}  // namespace
}  // namespace deepslam::eval
