#include "deepslam/tracking/relocalisation.h"

#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "support/pose_matchers.h"
#include "tracking/small_path.h"

namespace deepslam::tracking {
namespace {

using testing_support::Arc;
using testing_support::BoxWorld;
using testing_support::LookAt;
using testing_support::PoseNear;

// Four keyframes a quarter of the way round the room; then the lens was covered for a while.
class RelocaliseTest : public ::testing::Test {
 protected:
  RelocaliseTest() {
    for (int k = 0; k < 4; ++k)
      path_.Add(Posed(BoxWorld::Furnished(), truth_[static_cast<std::size_t>(k)], 5 * k));
  }

  // Behind the loss; where it truly is, is not told.
  [[nodiscard]] std::optional<Relocalisation> Find(const BoxWorld& world,
                                                   const Pose3& world_from_camera) const {
    PosedFrame frame = Posed(world, world_from_camera, 60);
    frame.world_from_camera = path_.previous.world_from_camera;
    return Relocalise(path_.SoFar(), frame);
  }

  const std::vector<Pose3> truth_ = Arc(4, 22.0);
  SmallPath path_;
};

TEST_F(RelocaliseTest, FindsTheKeyframeThatTheCameraIsBackAt) {
  const Pose3 beside = V2t((Vector6d() << 0.04, -0.02, 0.03, 0.02, 0.03, 0).finished());
  for (std::size_t k = 0; k < truth_.size(); ++k) {
    const Pose3 place = truth_[k] * beside;
    const auto found = Find(BoxWorld::Furnished(), place);
    ASSERT_TRUE(found.has_value()) << k;
    EXPECT_THAT(found->keyframe.world_from_camera * found->alignment.i_from_j,
                PoseNear(place, 0.015, 0.4))
        << k;
  }
}

TEST_F(RelocaliseTest, TakesTheLatestKeyframeThatFits) {
  SmallPath path = path_;
  path.Add(Posed(BoxWorld::Furnished(), truth_[0], 40));  // there again
  PosedFrame frame = Posed(BoxWorld::Furnished(), truth_[0], 60);
  const auto found = Relocalise(path.SoFar(), frame);
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->keyframe.frame, FrameIdx{40});
}

TEST_F(RelocaliseTest, FindsNothingWhereNoKeyframeSeesTheSame) {
  EXPECT_FALSE(Find(BoxWorld::Furnished(), LookAt({0, 0, 1.4}, {-1.9, 1.9, 1.0})).has_value());
  BoxWorld other = BoxWorld::Furnished();
  other.texture_phase = 2.0;
  other.boxes = {{{-0.6, 0.2, 0}, {0.1, 0.9, 0.5}}, {{0.6, -1.0, 0}, {1.2, -0.5, 1.0}}};
  for (const Pose3& place : truth_) EXPECT_FALSE(Find(other, place).has_value());
}

}  // namespace
}  // namespace deepslam::tracking
