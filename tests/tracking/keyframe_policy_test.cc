#include "deepslam/tracking/keyframe_policy.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "deepslam/core/angles.h"
#include "support/pose_matchers.h"
#include "tracking/small_path.h"

namespace deepslam::tracking {
namespace {

using alignment::FrameAlignment;
using testing_support::Arc;
using testing_support::BoxWorld;
using testing_support::PoseNear;

Pose3 Moved(double x_m, double turn_deg = 0) {
  return V2t((Vector6d() << x_m, 0, 0, 0, turn_deg * kRadPerDeg, 0).finished());
}

PosedFrame At(const Pose3& world_from_camera, double clock_s = 0) {
  PosedFrame frame;
  frame.world_from_camera = world_from_camera;
  frame.clock_s = clock_s;
  return frame;
}

// What an alignment to the keyframe says that sees nearly all that it sees.
FrameAlignment Near() {
  FrameAlignment alignment;
  alignment.inside_ratio = alignment.overlap_ratio = 0.95;
  return alignment;
}

TEST(IsFarFrom, IsToldByDistanceOrAngleEitherWay) {
  const OdometryOptions options;
  const Pose3 here = Moved(1, 30);
  const double distance_m = options.keyframe_distance_m, angle_deg = options.keyframe_angle_deg;
  for (const Pose3& near : {Pose3{}, Moved(0.9 * distance_m), Moved(0, 0.9 * angle_deg)})
    EXPECT_FALSE(IsFarFrom(here, here * near, options));
  for (const Pose3& far : {Moved(1.1 * distance_m), Moved(0, 1.1 * angle_deg)}) {
    EXPECT_TRUE(IsFarFrom(here, here * far, options));
    EXPECT_TRUE(IsFarFrom(here * far, here, options));
  }
}

TEST(WantsKeyframe, WhereTheFrameIsFarOrSeesTooLittleOfTheKeyframe) {
  const OdometryOptions options;
  const FrameAlignment near = Near();
  const auto wants = [&](const Pose3& place, const FrameAlignment* alignment) {
    return WantsKeyframe(At(Pose3{}), At(place), alignment, options);
  };
  EXPECT_FALSE(wants(Moved(0.01), &near));
  EXPECT_FALSE(wants(Moved(0.01), nullptr));
  EXPECT_TRUE(wants(Moved(2 * options.keyframe_distance_m), &near));
  EXPECT_TRUE(wants(Moved(2 * options.keyframe_distance_m), nullptr));
  FrameAlignment outside = near;
  outside.inside_ratio = 0.9 * options.keyframe_min_overlap;
  EXPECT_TRUE(wants(Moved(0.01), &outside));
  // Holes in the depth leave few common points; half of the overlap is enough then.
  FrameAlignment holes = near;
  holes.overlap_ratio = 0.6 * options.keyframe_min_overlap;
  EXPECT_FALSE(wants(Moved(0.01), &holes));
  holes.overlap_ratio = 0.4 * options.keyframe_min_overlap;
  EXPECT_TRUE(wants(Moved(0.01), &holes));
}

TEST(WantsKeyframe, WhereNothingHasShownTheMotionForLong) {
  FrameAlignment remapped = Near();
  remapped.remapped = true;
  const auto wants = [&](double clock_s, const FrameAlignment& alignment) {
    return WantsKeyframe(At(Pose3{}), At(Pose3{}, clock_s), &alignment, {});
  };
  EXPECT_FALSE(wants(0.3, remapped));
  EXPECT_TRUE(wants(0.7, remapped));
  EXPECT_FALSE(wants(0.7, Near()));
}

Matrix6d Information(double sigma) { return Matrix6d::Identity() / (sigma * sigma); }

TEST(Joined, LeavesMeasurementsThatAgreeAsTheyAre) {
  const Pose3 pose = Moved(0.4, 20);
  const JointMeasurement joint = Joined({pose, Information(0.01)}, {pose, Information(0.02)});
  EXPECT_EQ(joint.information_a, Information(0.01));
  EXPECT_EQ(joint.information_b, Information(0.02));
  EXPECT_THAT(joint.world_from_camera, PoseNear(pose, 1e-12, 1e-9));
}

TEST(Joined, LiesBetweenByWhatEitherIsWorthWhicheverComesFirst) {
  const Pose3 a = Moved(0.400), b = Moved(0.405);
  const JointMeasurement joint = Joined({a, Information(0.01)}, {b, Information(0.02)});
  // Weights 4 : 1.
  EXPECT_NEAR(joint.world_from_camera.translation_m.x(), 0.401, 1e-9);
  const JointMeasurement other = Joined({b, Information(0.02)}, {a, Information(0.01)});
  EXPECT_THAT(other.world_from_camera, PoseNear(joint.world_from_camera, 1e-9, 1e-6));
  EXPECT_TRUE(other.information_b.isApprox(joint.information_a));
}

TEST(Joined, BelievesLessOfMeasurementsThatContradictEachOther) {
  const double sigma = 0.01;
  double before = 1;
  for (const double apart_m : {0.02, 0.1, 0.4}) {
    const JointMeasurement joint =
        Joined({Pose3{}, Information(sigma)}, {Moved(apart_m), Information(sigma)});
    const double left = joint.information_a(0, 0) * sigma * sigma;
    EXPECT_LE(left, before) << apart_m;
    // Scaled down, the difference is what the covariances allow for: chi2 is 6 at most.
    const double chi2 = apart_m * apart_m * left / (2 * sigma * sigma);
    EXPECT_LE(chi2, 6 + 1e-9) << apart_m;
    before = left;
  }
  EXPECT_LT(before, 0.1);
}

class SkipEdges : public ::testing::Test {
 protected:
  // Two keyframes and the next one on an arc, at their true places.
  SkipEdges() {
    path_.Add(Posed(BoxWorld::Furnished(), truth_[0], 0));
    path_.Add(Posed(BoxWorld::Furnished(), truth_[1], 4));
    next_ = Posed(BoxWorld::Furnished(), truth_[2], 8);
    to_last_ = alignment::RefineAlignment(*path_.keyframes.last().pyramid,
                                          *next_.pyramid,
                                          truth_[1].Inverse() * truth_[2],
                                          path_.options.alignment);
  }

  [[nodiscard]] std::optional<SkipEdge> Measure() const {
    return MeasureSkipEdge(path_.keyframes, next_, to_last_, path_.options);
  }

  const std::vector<Pose3> truth_ = Arc(3, 4.0);
  SmallPath path_;
  PosedFrame next_;
  FrameAlignment to_last_;
};

TEST_F(SkipEdges, JoinAKeyframeToTheOneBeforeTheLast) {
  ASSERT_TRUE(to_last_.ok);
  const auto edge = Measure();
  ASSERT_TRUE(edge.has_value());
  EXPECT_THAT(edge->to_before_last.i_from_j, PoseNear(truth_[0].Inverse() * truth_[2], 0.01, 0.3));
  EXPECT_THAT(edge->joint.world_from_camera, PoseNear(truth_[2], 0.01, 0.3));
  EXPECT_LE(edge->joint.information_a(0, 0), to_last_.information(0, 0) * (1 + 1e-9));
}

TEST_F(SkipEdges, AreNotMeasuredWhereTheyAreNotAskedForOrTheWayBackIsNotOne) {
  path_.options.skip_edges = false;
  EXPECT_FALSE(Measure().has_value());
  path_.options.skip_edges = true;
  next_.sub_trajectory = 1;
  EXPECT_FALSE(Measure().has_value()) << "of another sub-trajectory";
  next_.sub_trajectory = 0;
  next_.world_from_camera = testing_support::LookAt({0.5, 0.5, 1.2}, {2, 2, 1.2});
  EXPECT_FALSE(Measure().has_value()) << "no overlap";
  SmallPath one;
  one.Add(Posed(BoxWorld::Furnished(), truth_[0], 0));
  EXPECT_FALSE(MeasureSkipEdge(one.keyframes, next_, to_last_, one.options).has_value());
}

TEST_F(SkipEdges, AreNotMeasuredPastAKeyframeWhoseMotionNothingShowed) {
  SmallPath path;
  PosedFrame first = Posed(BoxWorld::Furnished(), truth_[0], 0);
  PosedFrame last = Posed(BoxWorld::Furnished(), truth_[1], 4);
  last.remapped = true;
  path.Add(std::move(first));
  path.Add(std::move(last));
  EXPECT_FALSE(MeasureSkipEdge(path.keyframes, next_, to_last_, path.options).has_value());
}

}  // namespace
}  // namespace deepslam::tracking
