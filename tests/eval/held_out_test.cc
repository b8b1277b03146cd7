#include "deepslam/eval/held_out.h"

#include <gtest/gtest.h>

#include "support/box_meshes.h"

namespace deepslam::eval {
namespace {

// A box of 1 m, its front 2 m before the camera, and a depth image of one value.
HeldOutAgreement Judge(float depth_m) {
  const PinholeCamera camera{80, 60, 60, 60, 39.5, 29.5};
  return JudgeHeldOut(testing_support::BoxMesh({1, 1, 1}),
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

}  // namespace
}  // namespace deepslam::eval
