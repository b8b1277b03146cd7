#include "deepslam/tracking/placement.h"

#include <vector>

#include <gtest/gtest.h>

#include "deepslam/tracking/placement_acceptance.h"
#include "support/pose_matchers.h"
#include "tracking/small_path.h"

namespace deepslam::tracking {
namespace {

using alignment::FrameAlignment;
using testing_support::Arc;
using testing_support::BoxWorld;
using testing_support::PoseNear;

BoxWorld OtherRoom() {
  BoxWorld world = BoxWorld::Furnished();
  world.boxes = {{{-0.6, 0.2, 0}, {0.1, 0.9, 0.5}}, {{0.6, -1.0, 0}, {1.2, -0.5, 1.0}}};
  world.texture_phase = 1.3;
  return world;
}

TEST(IsConfident, AsksForInliersAndLikeImagesOrForTheSameImage) {
  FrameAlignment alignment;
  alignment.ok = true;
  const auto is_confident = [&](double inlier_ratio, double correlation) {
    alignment.inlier_ratio = inlier_ratio;
    alignment.intensity_correlation = correlation;
    return IsConfident(alignment);
  };
  EXPECT_TRUE(is_confident(0.9, 0.85));
  EXPECT_FALSE(is_confident(0.7, 0.85));
  EXPECT_FALSE(is_confident(0.9, 0.7));
  EXPECT_TRUE(is_confident(0.5, 0.97)) << "however poor the depth is";
  alignment.ok = false;
  EXPECT_FALSE(is_confident(0.9, 0.97));
}

TEST(StartsBehindPrevious, BeginWithTheExpectedPlaceWhereAMotionIsKnown) {
  const std::vector<Pose3> truth = Arc(3);
  SmallPath path;
  path.Add(Posed(BoxWorld::Furnished(), truth[1], 1));
  const PosedFrame frame = Posed(BoxWorld::Furnished(), truth[2], 2);
  EXPECT_EQ(StartsBehindPrevious(path.SoFar(), frame).world_from_camera.size(), 1U);
  path.motion.Observe(truth[0].Inverse() * truth[1], kFrameInterval_s, false);
  const Starts starts = StartsBehindPrevious(path.SoFar(), frame);
  ASSERT_EQ(starts.world_from_camera.size(), 2U);
  EXPECT_THAT(starts.world_from_camera[0], PoseNear(truth[2], 0.01, 0.3));
  EXPECT_EQ(starts.turned_from, &path.previous);
  path.options.motion_prediction = path.options.rotation_search = false;
  const Starts plain = StartsBehindPrevious(path.SoFar(), frame);
  EXPECT_EQ(plain.world_from_camera.size(), 1U);
  EXPECT_EQ(plain.turned_from, nullptr);
}

class PlaceTest : public ::testing::Test {
 protected:
  PlaceTest() {
    path_.Add(Posed(BoxWorld::Furnished(), truth_[0], 0));
    path_.Add(Posed(BoxWorld::Furnished(), truth_[1], 3));
  }

  [[nodiscard]] FrameAlignment PlaceAtLast(const PosedFrame& frame) const {
    return Place(path_.SoFar(),
                 path_.keyframes.last(),
                 path_.previous,
                 frame,
                 StartsBehindPrevious(path_.SoFar(), frame));
  }

  const std::vector<Pose3> truth_ = Arc(20, 5.0);
  SmallPath path_;
};

TEST_F(PlaceTest, FindsWhereAHandCarriedTheCamera) {
  const FrameAlignment found = PlaceAtLast(Posed(BoxWorld::Furnished(), truth_[2], 6));
  EXPECT_TRUE(found.ok);
  EXPECT_THAT(path_.keyframes.last().world_from_camera * found.i_from_j,
              PoseNear(truth_[2], 0.015, 0.4));
}

TEST_F(PlaceTest, DoesNotTakeAnotherRoomForThisOne) {
  for (const std::size_t k : {2U, 6U})
    EXPECT_FALSE(PlaceAtLast(Posed(OtherRoom(), truth_[k], 6)).ok) << k;
}

// What a place has to show: the same alignment, claimed of cameras that came there by likelier and
// less likely motions.
TEST_F(PlaceTest, AsksForMoreOfUnlikelyMotions) {
  const PosedFrame& reference = path_.keyframes.last();
  const auto is_accepted = [&](const PosedFrame& frame, const Pose3& place, bool is_confident) {
    FrameAlignment found;
    found.ok = true;
    found.i_from_j = reference.world_from_camera.Inverse() * place;
    found.inlier_ratio = is_confident ? 0.95 : 0.7;
    found.intensity_correlation = is_confident ? 0.9 : 0.7;
    return IsAcceptable(path_.SoFar(), reference, path_.previous, frame, found);
  };
  const PosedFrame near = Posed(BoxWorld::Furnished(), truth_[2], 6);
  EXPECT_TRUE(is_accepted(near, truth_[2], true));
  EXPECT_TRUE(is_accepted(near, truth_[2], false))
      << "it looks like it, and nothing speaks against";
  // A leap within a frame: all has to speak for it.
  const PosedFrame far = Posed(BoxWorld::Furnished(), truth_[8], 4);
  EXPECT_TRUE(is_accepted(far, truth_[8], true));
  EXPECT_FALSE(is_accepted(far, truth_[8], false));
  // Of another room nothing but the claim speaks for it.
  EXPECT_FALSE(is_accepted(Posed(OtherRoom(), truth_[2], 6), truth_[2], true));
}

TEST_F(PlaceTest, AcceptsEverythingInThePapersPlainBehaviour) {
  path_.options.reference = "previous";
  FrameAlignment found;
  found.ok = true;
  const PosedFrame& reference = path_.keyframes.last();
  EXPECT_TRUE(IsAcceptable(
      path_.SoFar(), reference, path_.previous, Posed(OtherRoom(), truth_[9], 4), found));
}

}  // namespace
}  // namespace deepslam::tracking
