// Frames that the path's own starts do not place, and what points of the images say of them.
#include "deepslam/tracking/feature_starts.h"

#include <vector>

#include <gtest/gtest.h>

#include "support/pose_matchers.h"
#include "tracking/small_path.h"

namespace deepslam::tracking {
namespace {

using testing_support::BoxWorld;
using testing_support::kRadPerDeg;
using testing_support::LookAt;
using testing_support::PoseNear;

// The camera stood at `before`; smeared depth covers most of what it sees now.
class PlaceByFeaturesTest : public ::testing::Test {
 protected:
  PlaceByFeaturesTest() { path_.Add(Posed(BoxWorld::Furnished(), before_, 0)); }

  [[nodiscard]] alignment::FrameAlignment Place(const Pose3& says, int num_inliers) const {
    const FeatureStarts features = [&](FrameIdx, FrameIdx) {
      return std::optional(FeatureStart{says, num_inliers});
    };
    PathSoFar path = path_.SoFar();
    path.features = &features;
    return PlaceByFeatures(path, path_.previous, path_.previous, frame_);
  }

  const Pose3 before_ = LookAt({-1.5, -0.5, 1.3}, {0.2, 0.1, 0.5});
  const Pose3 now_ = LookAt({-1.47, -0.48, 1.31}, {0.2, 0.3, 0.5});
  const Pose3 truth_ = before_.Inverse() * now_;
  SmallPath path_;
  PosedFrame frame_ = Posed(BoxWorld::Furnished(), now_, 2);
};

TEST_F(PlaceByFeaturesTest, ARightStartLeadsToThePlace) {
  const auto found = Place(truth_ * V2t((Vector6d() << 0.01, 0, 0.01, 0, 0.01, 0).finished()), 60);
  ASSERT_TRUE(found.ok);
  EXPECT_THAT(found.i_from_j, PoseNear(truth_, 0.01, 0.4));
}

// Of the frame's depth a fourteenth is left, less than an alignment by itself has to show.
TEST_F(PlaceByFeaturesTest, ManyPointsBearOutWhatLittleDepthCannot) {
  Frame view = testing_support::RenderFrame(BoxWorld::Furnished(), before_, 1.0, 0);
  for (int v = 0; v < view.depth_m.height(); ++v) {
    for (int u = 0; u < view.depth_m.width(); ++u)
      if (u < 74 || u > 96) view.depth_m(u, v) = 0;
  }
  PosedFrame narrow = path_.previous;
  narrow.pyramid = std::make_shared<const alignment::FramePyramid>(
      alignment::BuildPyramid(view, testing_support::kSmallCamera, {}));
  path_.Add(narrow);
  EXPECT_FALSE(Place(truth_, 25).ok) << "by chance as many";
  const auto found = Place(truth_, 60);
  ASSERT_TRUE(found.ok);
  EXPECT_THAT(found.i_from_j, PoseNear(truth_, 0.03, 1.0));
}

// However many points say so: what the alignment finds lies elsewhere, or does not fit.
TEST_F(PlaceByFeaturesTest, AWrongStartIsNotBelieved) {
  const Pose3 off = V2t((Vector6d() << 0.6, 0, 0.5, 0, 40 * kRadPerDeg, 0).finished());
  const auto found = Place(truth_ * off, 500);
  if (found.ok) {
    EXPECT_THAT(found.i_from_j, PoseNear(truth_, 0.02, 0.6));
  }
  BoxWorld other;
  other.texture_phase = 2;
  other.boxes = {{{-0.3, -0.2, 0}, {0.4, 1.0, 1.5}}};
  frame_ = Posed(other, LookAt({1.6, 1.5, 1.0}, {-0.5, 0.2, 0.8}), 2);
  EXPECT_FALSE(Place(truth_, 500).ok);
}

TEST_F(PlaceByFeaturesTest, NothingIsFoundWithoutAny) {
  EXPECT_FALSE(PlaceByFeatures(path_.SoFar(), path_.previous, path_.previous, frame_).ok);
  const FeatureStarts none = [](FrameIdx, FrameIdx) { return std::optional<FeatureStart>(); };
  PathSoFar path = path_.SoFar();
  path.features = &none;
  EXPECT_FALSE(PlaceByFeatures(path, path_.previous, path_.previous, frame_).ok);
}

}  // namespace
}  // namespace deepslam::tracking
