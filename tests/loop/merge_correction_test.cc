#include "deepslam/loop/merge_correction.h"

#include <gtest/gtest.h>

#include "loop/synthetic_traversals.h"
#include "support/pose_matchers.h"

namespace deepslam::loop {
namespace {

using ::deepslam::testing_support::PoseNear;
using testing_support::AddTraversal;
using testing_support::Clutter;
using testing_support::Detect;
using testing_support::Merged;
using testing_support::Scene;
using testing_support::Walk;
using testing_support::Yawed;

Constellation Accepted(int older, int newer, const Pose3& old_world_from_new_world) {
  Constellation made;
  made.pairs = {{ObjectId{older}, ObjectId{newer}}};
  made.old_world_from_new_world = old_world_from_new_world;
  made.accepted = true;
  return made;
}

const Pose3 kFirst = Yawed(0.3, -0.1, 0, 0.1);
const Pose3 kSecond = Yawed(-0.1, 0.4, 0, -0.05);

// The lowest number stays, and it need not be the one that was seen first.
TEST(MergeCorrection, GoesWithTheTimeAndAgainstIt) {
  Loops loops;
  loops.constellations = {Accepted(5, 2, kFirst)};
  EXPECT_THAT(CorrectionOf({ObjectId{5}, ObjectId{2}}, loops), PoseNear(kFirst, 1e-12, 1e-9));
  EXPECT_THAT(CorrectionOf({ObjectId{2}, ObjectId{5}}, loops),
              PoseNear(kFirst.Inverse(), 1e-12, 1e-9));
}

TEST(MergeCorrection, GoesByWayOfTheVisitBetween) {
  Loops loops;
  loops.constellations = {Accepted(1, 4, kFirst), Accepted(4, 7, kSecond)};
  EXPECT_THAT(CorrectionOf({ObjectId{1}, ObjectId{7}}, loops),
              PoseNear(kFirst * kSecond, 1e-12, 1e-9));
  loops.constellations.push_back(Accepted(1, 7, kSecond));
  EXPECT_THAT(CorrectionOf({ObjectId{1}, ObjectId{7}}, loops), PoseNear(kSecond, 1e-12, 1e-9))
      << "the direct one";
}

TEST(MergeCorrection, IsNoneWhereNothingAcceptedLeads) {
  Loops loops;
  loops.constellations = {Accepted(1, 4, kFirst)};
  loops.constellations.front().accepted = false;
  EXPECT_THAT(CorrectionOf({ObjectId{1}, ObjectId{4}}, loops), PoseNear(Pose3{}, 1e-12, 1e-9));
  EXPECT_THAT(CorrectionOf({ObjectId{1}, ObjectId{9}}, Loops{}), PoseNear(Pose3{}, 1e-12, 1e-9));
}

TEST(MergeCorrection, BringsAMergedObjectOntoItsOther) {
  Scene scene;
  scene.odometry = Walk(400, 20);
  const auto room = Clutter(1, 4);
  const Pose3 drift = Yawed(0.4, 0.2, 0, 0.1);
  AddTraversal(scene, {{"chair", 0, 0, 0.3}, {"chair", 0.9, 0.1, 2}}, 300, drift, room);
  AddTraversal(scene, {{"chair", 0, 0, 0.3}, {"chair", 0.9, 0.1, 2}}, 0, {}, room);
  const Loops loops = Detect(scene);
  ASSERT_EQ(Merged(loops).size(), 2U);
  for (const ObjectMerge& merge : loops.merges)  // here the later traversal has the lower ids
    EXPECT_THAT(CorrectionOf(merge, loops), PoseNear(drift, 0.05, 2.0));
}

}  // namespace
}  // namespace deepslam::loop
