#include "deepslam/loop/constellation.h"

#include <limits>

#include <gtest/gtest.h>

#include "loop/synthetic_traversals.h"
#include "support/pose_matchers.h"

namespace deepslam::loop {
namespace {

using ::deepslam::testing_support::PoseNear;
using testing_support::AddTraversal;
using testing_support::Classes;
using testing_support::Clutter;
using testing_support::Detect;
using testing_support::Furniture;
using testing_support::Merged;
using testing_support::Scene;
using testing_support::Walk;
using testing_support::Yawed;

using Merges = std::set<std::pair<int, int>>;

const std::vector<Furniture> kRoom = {
    {"chair", 0, 0, 0.3}, {"chair", 1.4, 0.2, 2.0}, {"couch", 0.3, 1.9, -1.0}};

// Both traversals of the same room, the second one drifted.
Scene Revisit(const std::vector<Furniture>& furniture, const Pose3& drifted_from_true) {
  Scene scene;
  scene.odometry = Walk(400, 20);
  const auto room = Clutter(1, 4);
  AddTraversal(scene, furniture, 0, {}, room);
  AddTraversal(scene, furniture, 300, drifted_from_true, room);
  return scene;
}

TEST(Loops, ATrueRevisitIsFoundAndCorrected) {
  Random random(2);
  int closed = 0;
  constexpr int kTries = 10;
  for (int n = 0; n < kTries; ++n) {
    const Pose3 drift = Yawed(random.Uniform(-0.5, 0.5),
                              random.Uniform(-0.5, 0.5),
                              random.Uniform(-0.1, 0.1),
                              random.Uniform(-0.15, 0.15));
    const Loops loops = Detect(Revisit(kRoom, drift));
    if (Merged(loops) != Merges{{0, 3}, {1, 4}, {2, 5}}) continue;
    ++closed;
    EXPECT_THAT(loops.constellations.front().old_world_from_new_world,
                PoseNear(drift.Inverse(), 0.05, 2.0));
    ASSERT_FALSE(loops.edges.empty());
    for (const RelativePose& edge : loops.edges) {
      EXPECT_LT(edge.i.value, 100);
      EXPECT_GE(edge.j.value, 300);
    }
  }
  EXPECT_GE(closed, 9 * kTries / 10);
}

TEST(Loops, WorksInAWorldThatIsNotLevel) {
  Scene scene = Revisit(kRoom, Yawed(0.3, -0.2, 0.05, 0.1));
  const Loops level = Detect(scene);
  const Pose3 tilt = V2t((Vector6d() << 0.4, 1, -2, 1.4, -0.4, 0.3).finished());
  for (MapObject& object : scene.map.objects)
    object.world_from_object = tilt * object.world_from_object;
  for (auto& [id, evidence] : scene.evidence) {
    for (auto* points : {&evidence.depth_points_world,
                         &evidence.model_points_world,
                         &evidence.surroundings_world}) {
      *points = testing_support::Moved(*points, tilt);
    }
  }
  const Loops tilted = Detect(scene);
  EXPECT_EQ(Merged(tilted), Merged(level));
  EXPECT_EQ(Merged(tilted).size(), 3u);
  EXPECT_THAT(
      tilted.constellations.front().old_world_from_new_world,
      PoseNear(tilt * level.constellations.front().old_world_from_new_world * tilt.Inverse(),
               0.03,
               1.0));
}

TEST(Loops, OtherClassesOrAnotherArrangementAreNoLoop) {
  for (const Furniture& changed : {Furniture{"bed", 1.4, 0.2, 2.0},
                                   Furniture{"chair", 2.2, 0.2, 2.0},
                                   Furniture{"chair", 1.4, 0.2, 0.0}}) {
    Scene scene;
    scene.odometry = Walk(400, 20);
    const auto room = Clutter(1, 4);
    AddTraversal(scene, {{"chair", 0, 0, 0.3}, {"chair", 1.4, 0.2, 2.0}}, 0, {}, room);
    AddTraversal(scene, {{"chair", 0, 0, 0.3}, changed}, 300, Yawed(0.5, 0.4, 0, 0), room);
    const Loops loops = Detect(scene);
    EXPECT_TRUE(loops.merges.empty())
        << changed.class_name << " " << changed.x_m << " " << changed.yaw_rad;
  }
}

TEST(Loops, FreeYawIsNotCompared) {
  const std::vector<Furniture> turned_before = {{"table", 0, 0, 0.3}, {"table", 1.6, 0.4, 2.0}};
  std::vector<Furniture> turned_after = turned_before;
  turned_after[1].yaw_rad += 1.57;
  for (const bool free : {true, false}) {
    ClassTable classes = Classes();
    classes.classes[1].traits.yaw_free = free;
    Scene scene;
    scene.odometry = Walk(400, 20);
    AddTraversal(scene, turned_before, 0, {}, {});
    AddTraversal(scene, turned_after, 300, Yawed(0.3, -0.4, 0, 0.05), {});
    const auto found = FindIn(scene, {}, classes).constellations;
    EXPECT_EQ(!found.empty() && found.front().pairs.size() == 2, free);
  }
  // A class with a yaw whose views all say it is not observable.
  Scene scene;
  scene.odometry = Walk(400, 20);
  AddTraversal(scene, turned_before, 0, {}, {});
  AddTraversal(scene, turned_after, 300, Yawed(0.3, -0.4, 0, 0.05), {});
  for (ViewRegistration& view : scene.map.objects[3].views) view.yaw_free = true;
  ClassTable classes = Classes();
  classes.classes[1].traits.yaw_free = false;
  const auto found = FindIn(scene, {}, classes);
  EXPECT_EQ(found.constellations.size(), 1u);
}

// The same two chairs stand twice, a metre apart, and the second traversal shows two chairs between
// both places.
TEST(Loops, AmbiguousOnesAreRefused) {
  Scene scene;
  scene.odometry = Walk(400, 30);
  const std::vector<Furniture> pair = {{"chair", 0, 0, 0}, {"chair", 0, 1.2, 0}};
  const std::vector<Furniture> same_pair = {{"chair", 1.4, 0, 0}, {"chair", 1.4, 1.2, 0}};
  AddTraversal(scene, pair, 0, {}, {});
  AddTraversal(scene, same_pair, 40, {}, {});
  AddTraversal(scene, pair, 300, Yawed(0.7, 0, 0, 0), {});
  LoopOptions options;
  options.drift_base_m =
      1.0;  // objects alone may be accepted that far: only the ambiguity is left to refuse
  const std::vector<Constellation> found = FindIn(scene, options).constellations;
  ASSERT_GE(found.size(), 2u);
  const Loops loops = Detect(scene, options);
  EXPECT_TRUE(loops.merges.empty());
  EXPECT_TRUE(loops.edges.empty());
  EXPECT_NE(loops.constellations.front().reason.find("ambiguous"), std::string::npos)
      << loops.constellations.front().reason;
}

// Rows of equal chairs: every shift by a row or a column brings most of them onto others.
TEST(Loops, OfAClassroomsConstellationsTheTrueOneHasMostPairs) {
  constexpr int kRows = 5;
  std::vector<Furniture> chairs;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kRows; ++column)
      chairs.push_back({"chair", 1.0 * row, 0.8 * column, 0.0});
  }
  Scene scene;
  scene.odometry = Walk(400, 30);
  AddTraversal(scene, chairs, 0, {}, {});
  AddTraversal(scene, chairs, 300, Yawed(0.3, -0.2, 0, 0.03), {});
  LoopOptions options;
  const FoundConstellations found = FindIn(scene, options);
  EXPECT_TRUE(found.complete);
  ASSERT_FALSE(found.constellations.empty());
  EXPECT_EQ(found.constellations.front().pairs.size(), chairs.size());
  for (const ObjectMerge& pair : found.constellations.front().pairs)
    EXPECT_EQ(pair.merged.value - pair.kept.value, static_cast<int>(chairs.size()));

  options.max_seeds = 3;
  EXPECT_FALSE(FindIn(scene, options).complete);
}

TEST(Loops, SurroundingsTellEqualFurnitureApart) {
  const std::vector<Furniture> pair = {{"chair", 0, 0, 0}, {"chair", 0, 1.2, 0}};
  for (const bool same_place : {true, false}) {
    Scene scene;
    scene.odometry = Walk(400, 30);
    AddTraversal(scene, pair, 0, {}, Clutter(1, 4));
    AddTraversal(scene, pair, 300, Yawed(1.0, 0.2, 0, 0.02), Clutter(same_place ? 1 : 2, 4));
    EXPECT_EQ(Detect(scene).merges.size(), same_place ? 2u : 0u);
  }
}

TEST(Loops, SurroundingsThatAreRightAsTheyStandRefuseACorrection) {
  const std::vector<Furniture> pair = {{"chair", 0, 0, 0}, {"chair", 0, 1.2, 0}};
  const Pose3 drift = Yawed(0.5, 0.2, 0, 0.02);
  const auto room = Clutter(1, 4);
  // Six tenths of the room stand where the correction puts them, and all of it as it was.
  const auto most = static_cast<std::ptrdiff_t>(room.size() * 6 / 10);
  std::vector<Eigen::Vector3f> seen_again(room.begin(), room.begin() + most);
  for (const bool stands_still : {false, true}) {
    if (stands_still) {
      for (const Eigen::Vector3f& p : testing_support::Moved(room, drift.Inverse()))
        seen_again.push_back(p);
    }
    Scene scene;
    scene.odometry = Walk(400, 30);
    AddTraversal(scene, pair, 0, {}, room);
    AddTraversal(scene, pair, 300, drift, seen_again);
    EXPECT_EQ(Detect(scene).merges.size(), stands_still ? 0U : 2U);
  }
}

TEST(Loops, WithoutSurroundingsDistantCopiesStayApart) {
  const std::vector<Furniture> pair = {{"chair", 0, 0, 0}, {"chair", 0, 1.2, 0}};
  Scene scene;
  scene.odometry = Walk(400, 30);
  AddTraversal(scene, pair, 0, {}, {});
  AddTraversal(scene, pair, 300, Yawed(1.0, 0.2, 0, 0.02), {});
  EXPECT_TRUE(Detect(scene).merges.empty());
  Scene near;
  near.odometry = Walk(400, 30);
  AddTraversal(near, pair, 0, {}, {});
  AddTraversal(near, pair, 300, Yawed(0.2, 0.1, 0, 0.02), {});
  EXPECT_EQ(Detect(near).merges.size(), 2u);
}

TEST(Loops, MoreThanTrackingDriftsIsNoLoop) {
  Scene scene = Revisit(kRoom, Yawed(1.0, 0, 0, 0));
  EXPECT_FALSE(Detect(scene).merges.empty());
  scene.odometry = Walk(400, 4);  // the same correction after a short walk
  EXPECT_TRUE(Detect(scene).merges.empty());
}

TEST(Loops, ObjectsOfOneFrameAreNeverOne) {
  Scene scene = Revisit(kRoom, Yawed(0.1, 0, 0, 0));
  // One frame of the second traversal sees the first traversal's chair beside the new one.
  scene.association.tracks[0].members.push_back(
      {DetectionId{9999}, FrameIdx{305}, 1, 0.01, "model"});
  EXPECT_EQ(Merged(Detect(scene)), (Merges{{1, 4}, {2, 5}}));
}

TEST(Loops, ADuplicateInItsPlaceIsMergedWithoutASecondPair) {
  Scene scene;
  scene.odometry = Walk(100, 1);
  AddTraversal(scene, {{"chair", 0, 0, 0}}, 0, {}, {});
  AddTraversal(scene, {{"chair", 0, 0, 0}}, 20, Yawed(0.05, 0.04, 0, 0.02), {});
  AddTraversal(scene, {{"chair", 0.7, 0, 0}}, 40, {}, {});
  EXPECT_EQ(Merged(Detect(scene)), (Merges{{0, 1}}));
  LoopOptions options;
  options.merge_overlapping = false;
  EXPECT_TRUE(Detect(scene, options).merges.empty());
}

TEST(Loops, WhatStandsInOnePlaceMayBeInTwoRoomsWhereNothingTiesThePathTogether) {
  Scene scene;
  scene.odometry = Walk(100, 1);
  AddTraversal(scene, {{"chair", 0, 0, 0}}, 0, {}, {});
  AddTraversal(scene, {{"chair", 0, 0, 0}}, 50, Yawed(0.05, 0.04, 0, 0.02), {});
  EXPECT_EQ(Merged(Detect(scene)), (Merges{{0, 1}}));
  scene.odometry.frames[40].status = TrackingStatus::kLost;
  scene.odometry.edges.push_back({FrameIdx{30}, FrameIdx{40}, {}, Matrix6d::Identity(), true});
  EXPECT_TRUE(Detect(scene).merges.empty());
  scene.odometry.edges.push_back({FrameIdx{10}, FrameIdx{60}, {}, Matrix6d::Identity(), false});
  EXPECT_EQ(Merged(Detect(scene)), (Merges{{0, 1}}));
}

// A top on four legs, about its middle.
std::vector<Eigen::Vector3f> TablePoints() {
  std::vector<Eigen::Vector3f> points;
  for (float x = -0.6F; x <= 0.6F; x += 0.025F) {
    for (float y = -0.4F; y <= 0.4F; y += 0.025F) {
      points.emplace_back(x, y, 0.3F);
      if (std::abs(x) > 0.56F && std::abs(y) > 0.36F) {
        for (float z = -0.45F; z < 0.3F; z += 0.025F) points.emplace_back(x, y, z);
      }
    }
  }
  return points;
}

TEST(Loops, DepthTellsAThingOfTwoClassesFromAChairUnderATable) {
  LoopOptions options;
  options.min_single_overlap = 0;  // what models say is enough for one class alone
  for (const bool same_thing : {true, false}) {
    Scene scene;
    scene.odometry = Walk(100, 1);
    const auto room = Clutter(1, 4);
    AddTraversal(scene, {{"chair", 0, 0, 0}}, 0, {}, room);
    AddTraversal(
        scene, {{same_thing ? "cabinet" : "table", 0, 0, 0}}, 40, Yawed(0.1, 0, 0, 0), room);
    if (!same_thing) {
      ObjectEvidence& table = scene.evidence[ObjectId{1}];
      table.depth_points_world = testing_support::Moved(TablePoints(), Yawed(0.1, 0, 0.45, 0));
      table.model_points_world = table.depth_points_world;
    }
    EXPECT_EQ(Merged(Detect(scene, options)), same_thing ? (Merges{{0, 1}}) : Merges{});
  }
}

TEST(Loops, ADuplicateThatModelsDoNotShowIsFoundInTheDepth) {
  LoopOptions options;
  options.min_single_overlap = 1;
  for (const bool same_room : {true, false}) {
    Scene scene;
    scene.odometry = Walk(100, 1);
    AddTraversal(scene, {{"chair", 0, 0, 0}}, 0, {}, Clutter(1, 4));
    AddTraversal(
        scene, {{"chair", 0, 0, 0}}, 40, Yawed(0.12, 0.05, 0, 0.02), Clutter(same_room ? 1 : 2, 4));
    EXPECT_EQ(Detect(scene, options).merges.size(), same_room ? 1U : 0U);
  }
}

TEST(Loops, AChainOfTraversalsEndsInTheLowestId) {
  Scene scene;
  scene.odometry = Walk(800, 30);
  const auto room = Clutter(1, 4);
  AddTraversal(scene, kRoom, 0, {}, room);
  AddTraversal(scene, kRoom, 300, Yawed(0.3, 0.1, 0, 0.05), room);
  AddTraversal(scene, kRoom, 700, Yawed(0.5, -0.2, 0, -0.05), room);
  const Loops loops = Detect(scene);
  EXPECT_EQ(Merged(loops), (Merges{{0, 3}, {0, 6}, {1, 4}, {1, 7}, {2, 5}, {2, 8}}));
  EXPECT_EQ(loops.merges.size(), 6u) << "each merged once";
}

TEST(Loops, TheOrderOfObjectsChangesNothing) {
  Scene scene = Revisit(kRoom, Yawed(0.3, 0.1, 0, 0.05));
  const Loops first = Detect(scene);
  const Loops again = Detect(scene);
  ASSERT_EQ(first.edges.size(), again.edges.size());
  for (std::size_t k = 0; k < first.edges.size(); ++k) {
    EXPECT_EQ(first.edges[k].i_from_j, again.edges[k].i_from_j);
  }
  std::reverse(scene.map.objects.begin(), scene.map.objects.end());
  EXPECT_EQ(Merged(Detect(scene)), Merged(first));
}

TEST(Loops, NothingAndNonsense) {
  EXPECT_TRUE(Detect({}).merges.empty());
  Scene scene = Revisit(kRoom, Yawed(0.3, 0.1, 0, 0.05));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  scene.evidence[ObjectId{0}].depth_points_world[5] = {nan, 0, 0};
  scene.evidence[ObjectId{3}].surroundings_world[5] = {1e30F, 0, 0};
  EXPECT_EQ(Detect(scene).merges.size(), 3u);
  scene.map.objects[0].world_from_object.translation_m.x() = nan;
  EXPECT_EQ(Detect(scene).merges.size(), 2u);
  scene.evidence.clear();
  EXPECT_TRUE(Detect(scene).merges.empty());
  LoopOptions off;
  off.enabled = false;
  EXPECT_TRUE(Detect(Revisit(kRoom, {}), off).constellations.empty());
}

}  // namespace
}  // namespace deepslam::loop
