// Loops closed by objects in a furnished room that is traversed twice: duplicates and
// constellations merged, others rejected, tracks split and rejoined.
#include "deepslam/modelling/close_loops.h"
#include "deepslam/modelling/candidate_set.h"

#include <algorithm>
#include <set>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deepslam/core/parallel.h"
#include "modelling/furnished_room.h"
#include "support/pose_matchers.h"

namespace deepslam::modelling {
namespace {

using ::deepslam::testing_support::ChairGrid;
using ::deepslam::testing_support::PoseNear;
using ::deepslam::testing_support::StoolGrid;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing_support::Frames;
using testing_support::Furniture;
using testing_support::Joined;
using testing_support::kFramesPerTraversal;
using testing_support::kSecondTraversal;
using testing_support::ModelledRoom;
using testing_support::Yawed;

// Registration with exact models and a millimetre's noise.
constexpr double kPlace_m = 0.03;
constexpr double kTurn_deg = 3;

const Furniture kChair = {"chair", ChairGrid(), 0.9, 0.0, -0.5, 0.4};
const Furniture kOther = {"chair", ChairGrid(), 0.9, -0.5, 0.8, 2.2};
const std::vector<int> kFirst = Frames(0, kFramesPerTraversal);
const std::vector<int> kSecond = Frames(kSecondTraversal, kFramesPerTraversal);

MapWithLoops MapOf(const ModelledRoom& room, const Selection& selection) {
  MapWithLoops map;
  map.tracked = static_cast<const Trajectory&>(room.room.odometry);
  map.odometry = room.room.odometry;
  map.ground = room.room.ground;
  map.association = room.association;
  map.proposals = room.proposals;
  map.proposals.models.clear();
  Proposals made = selection.made;
  made.models.clear();
  Append(std::move(made), map.proposals);
  map.map = selection.map;
  return map;
}

ObjectOptions AsProposed() {
  ObjectOptions options;
  options.refinement.complete = false;
  return options;
}

// The objects selected, then loops closed.
Result<ClosedMap> Close(ModelledRoom& room,
                        const loop::LoopOptions& loops = {},
                        const ObjectOptions& objects = AsProposed()) {
  const Result<Selection> selection = room.Select(objects);
  if (!selection.ok()) return selection.error();
  for (const auto& [key, grid] : selection->made.models) room.models.grids.emplace(key, grid);
  const FrameViews views = room.Views();
  const ObjectSources sources{views, room.models, room.prepared, room.progress};
  return CloseLoops(MapOf(room, *selection), {sources, {}, objects, loops, {}});
}

std::set<std::pair<int, int>> Merged(const Loops& loops) {
  std::set<std::pair<int, int>> merged;
  for (const ObjectMerge& merge : loops.merges)
    merged.emplace(merge.kept.value, merge.merged.value);
  return merged;
}

using Merges = std::set<std::pair<int, int>>;

std::vector<int> Ids(const ObjectMap& map) {
  std::vector<int> ids;
  for (const MapObject& object : map.objects) ids.push_back(object.id.value);
  return ids;
}

// Where a piece of furniture stands along the tracked path: as the object's best view saw it.
Pose3 TruthAsTracked(const ModelledRoom& room, const MapObject& object, std::size_t item) {
  const auto best = std::ranges::max_element(object.views, {}, &ViewRegistration::inlier_share);
  const auto& seen = room.room;
  return seen.odometry.at(best->frame).world_from_camera * seen.true_pose(best->frame).Inverse() *
         seen.truth(item).RigidPart();
}

// Association lost a chair and found it again as another one; nothing drifts.
TEST(CloseLoops, MergesTwoObjectsThatAreOne) {
  ModelledRoom room({kChair});
  room.Track(0, 0, Frames(0, 4));
  room.Track(1, 0, Frames(4, 4));
  const Result<ClosedMap> closed = Close(room);
  ASSERT_TRUE(closed.ok()) << closed.error().message;
  EXPECT_EQ(Merged(closed->loops), (Merges{{0, 1}}));
  ASSERT_THAT(Ids(closed->map), ElementsAre(0));
  const MapObject& chair = closed->map.objects[0];
  EXPECT_THAT(chair.merged, ElementsAre(ObjectId{1}));
  EXPECT_EQ(chair.views.size(), 8U);
  EXPECT_THAT(chair.world_from_object,
              PoseNear(room.room.truth(0).RigidPart(), kPlace_m, kTurn_deg));
  ASSERT_EQ(closed->association.tracks.size(), 1U);
  const std::vector<TrackMember>& members = closed->association.tracks[0].members;
  ASSERT_EQ(members.size(), 8U);
  EXPECT_TRUE(std::ranges::is_sorted(members, {}, &TrackMember::frame));
  EXPECT_EQ(std::ranges::count(members, "merge", &TrackMember::how), 4);
  // Both candidates compete for it, each registered in all views.
  ASSERT_EQ(closed->registrations.size(), 2U);
  for (const CandidateRegistration& registration : closed->registrations)
    EXPECT_EQ(registration.views.size(), 8U);
}

TEST(CloseLoops, OfTwoClassesTheOneSeenMoreOftenStays) {
  Furniture sofa = kChair;
  sofa.class_name = "sofa";
  ModelledRoom room({kChair, kChair});
  room.Track(0, 0, Frames(0, 3));
  room.Track(1, 0, Frames(3, 5));
  room.association.tracks[1].class_name = "stool";
  loop::LoopOptions loops;
  loops.min_object_agreement = 0.3;
  const Result<ClosedMap> closed = Close(room, loops);
  ASSERT_TRUE(closed.ok()) << closed.error().message;
  ASSERT_THAT(Ids(closed->map), ElementsAre(0));
  EXPECT_EQ(closed->map.objects[0].class_name, "stool");
  EXPECT_EQ(closed->association.tracks[0].class_name, "stool");
}

// Both chairs are seen again behind drift, as two further ones.
TEST(CloseLoops, AConstellationSeenAgainClosesTheLoop) {
  const Pose3 drift = Yawed(0.30, -0.25, 0.04);
  ModelledRoom room({kChair, kOther}, drift);
  room.Track(0, 0, kFirst);
  room.Track(1, 1, kFirst);
  room.Track(2, 0, kSecond);
  room.Track(3, 1, kSecond);
  const Result<ClosedMap> closed = Close(room);
  ASSERT_TRUE(closed.ok()) << closed.error().message;
  EXPECT_EQ(Merged(closed->loops), (Merges{{0, 2}, {1, 3}}));
  ASSERT_THAT(Ids(closed->map), ElementsAre(0, 1));
  for (std::size_t n = 0; n < 2; ++n) {
    EXPECT_THAT(closed->map.objects[n].world_from_object,
                PoseNear(TruthAsTracked(room, closed->map.objects[n], n), 2 * kPlace_m, kTurn_deg));
  }
  ASSERT_FALSE(closed->loops.constellations.empty());
  const Constellation& seen_again = closed->loops.constellations.front();
  EXPECT_TRUE(seen_again.accepted) << seen_again.reason;
  EXPECT_THAT(seen_again.old_world_from_new_world, PoseNear(drift.Inverse(), 0.05, 2.0));
  ASSERT_FALSE(closed->loops.edges.empty());
  for (const RelativePose& edge : closed->loops.edges) {
    const Pose3 truth = room.room.true_pose(edge.i).Inverse() * room.room.true_pose(edge.j);
    EXPECT_THAT(edge.i_from_j, PoseNear(truth, 0.06, 2.0));
  }
}

// Two chairs stand in the first traversal's corner and two in the same arrangement beside them, and
// each traversal has eyes for its own alone: what stands around says that they are not the same.
TEST(CloseLoops, AnEqualArrangementBesideIsRejected) {
  const Pose3 beside = Yawed(0.0, 1.3, 0.0);
  std::vector<Furniture> chairs = {kChair, kOther, kChair, kOther};
  for (std::size_t n : {0U, 1U}) chairs[n].y_m -= 0.6;
  for (std::size_t n : {0U, 1U}) {
    chairs[n + 2].x_m = chairs[n].x_m + beside.translation_m.x() - 0.1;
    chairs[n + 2].y_m = chairs[n].y_m + 0.7;
  }
  ModelledRoom room(chairs);
  room.Track(0, 0, kFirst);
  room.Track(1, 1, kFirst);
  room.Track(2, 2, kSecond);
  room.Track(3, 3, kSecond);
  const Result<Selection> selection = room.Select(AsProposed());
  ASSERT_TRUE(selection.ok());
  const Result<ClosedMap> closed = Close(room);
  ASSERT_TRUE(closed.ok()) << closed.error().message;
  ASSERT_FALSE(closed->loops.constellations.empty());
  for (const Constellation& constellation : closed->loops.constellations)
    EXPECT_FALSE(constellation.accepted) << constellation.reason;
  EXPECT_THAT(closed->loops.merges, IsEmpty());
  EXPECT_THAT(closed->loops.edges, IsEmpty());
  ASSERT_EQ(closed->map.objects.size(), selection->map.objects.size());
  for (std::size_t n = 0; n < closed->map.objects.size(); ++n) {
    EXPECT_EQ(closed->map.objects[n].world_from_object,
              selection->map.objects[n].world_from_object);
  }
  EXPECT_THAT(closed->made.candidates, IsEmpty());
  EXPECT_THAT(closed->registrations, IsEmpty());
}

// Association knows the chair again behind drift: its views agree on no place.
struct ReobservedRoom : ModelledRoom {
  explicit ReobservedRoom(const Pose3& drift) : ModelledRoom({kChair, kOther}, drift) {
    Track(0, 0, Joined(kFirst, kSecond));
    Track(1, 1, kFirst);
  }
};

TEST(CloseLoops, ATrackThatDriftTearsApartIsSplitAndTheLoopClosed) {
  ReobservedRoom room(Yawed(0.30, -0.20, 0.03));
  loop::LoopOptions loops;
  loops.min_room_points = 50;  // small images: few points fall on what stands along the walls
  const Result<ClosedMap> closed = Close(room, loops);
  ASSERT_TRUE(closed.ok()) << closed.error().message;
  ASSERT_EQ(closed->loops.tracklets.size(), 2U);
  EXPECT_EQ(closed->loops.tracklets[0].tracklet, ObjectId{0});
  EXPECT_EQ(closed->loops.tracklets[1].object, ObjectId{0});
  EXPECT_EQ(closed->loops.tracklets[1].first, FrameIdx{kSecondTraversal});
  EXPECT_EQ(Merged(closed->loops), (Merges{{0, closed->loops.tracklets[1].tracklet.value}}));
  ASSERT_THAT(Ids(closed->map), ElementsAre(0, 1));
  const std::vector<ViewRegistration>& views = closed->map.objects[0].views;
  EXPECT_TRUE(
      std::ranges::any_of(views, [](const auto& v) { return v.frame.value < kSecondTraversal; }));
  EXPECT_TRUE(
      std::ranges::any_of(views, [](const auto& v) { return v.frame.value >= kSecondTraversal; }));
  EXPECT_THAT(closed->map.objects[0].world_from_object,
              PoseNear(TruthAsTracked(room, closed->map.objects[0], 0), 2 * kPlace_m, kTurn_deg));
  EXPECT_EQ(closed->association.tracks[0].members.size(), 2U * kFramesPerTraversal);
}

// Where nothing is known of what stands around, depth of one chair alone is not accepted.
TEST(CloseLoops, ASplitTrackThatNoLoopJoinsIsWholeAgain) {
  ReobservedRoom room(Yawed(0.30, -0.20, 0.03));
  loop::LoopOptions loops;
  loops.min_room_points = 1000000;
  const Result<Selection> selection = room.Select(AsProposed());
  ASSERT_TRUE(selection.ok());
  const Result<ClosedMap> closed = Close(room, loops);
  ASSERT_TRUE(closed.ok()) << closed.error().message;
  EXPECT_EQ(closed->loops.tracklets.size(), 2U);
  EXPECT_THAT(closed->loops.merges, IsEmpty());
  EXPECT_EQ(Ids(closed->map), Ids(selection->map));
  EXPECT_EQ(closed->map.objects[0].world_from_object, selection->map.objects[0].world_from_object);
  EXPECT_EQ(closed->association.tracks[0].members.size(), 2U * kFramesPerTraversal);
  EXPECT_THAT(closed->made.candidates, IsEmpty());
}

// Appearance moved the path, so that the object was completed anew before its track was split.
TEST(CloseLoops, WhatIsWholeAgainKeepsTheModelThatWasMadeForIt) {
  ReobservedRoom room(Yawed(0.30, -0.20, 0.03));
  const Result<Selection> selection = room.Select({});
  ASSERT_TRUE(selection.ok());
  for (const auto& [key, grid] : selection->made.models) room.models.grids.emplace(key, grid);
  const FrameViews views = room.Views();
  const ObjectSources sources{views, room.models, room.prepared, room.progress};
  MapWithLoops before = MapOf(room, *selection);
  for (std::size_t k = kSecondTraversal; k < before.odometry.frames.size(); ++k)
    before.odometry.frames[k].world_from_camera.translation_m.x() -= 0.15;
  loop::LoopOptions loops;
  loops.min_room_points = 1000000;
  graph::GraphOptions graph;
  graph.use_objects = false;  // the path stays where appearance moved it
  const Result<ClosedMap> closed =
      CloseLoops(std::move(before), {sources, {}, ObjectOptions(), loops, graph});
  ASSERT_TRUE(closed.ok()) << closed.error().message;
  ASSERT_EQ(closed->loops.tracklets.size(), 2U);
  ASSERT_THAT(closed->loops.merges, IsEmpty());
  const MapObject& whole = closed->map.objects.front();
  EXPECT_THAT(whole.model, HasSubstr("closed_"));
  EXPECT_TRUE(closed->made.models.contains(whole.model)) << whole.model;
}

TEST(CloseLoops, ATrackThatStandsTogetherIsNotSplit) {
  ReobservedRoom room({});
  const Result<ClosedMap> closed = Close(room);
  ASSERT_TRUE(closed.ok()) << closed.error().message;
  EXPECT_THAT(closed->loops.tracklets, IsEmpty());
  EXPECT_THAT(closed->loops.merges, IsEmpty());
  EXPECT_THAT(Ids(closed->map), ElementsAre(0, 1));
}

TEST(CloseLoops, SwitchedOffNothingIsFound) {
  ModelledRoom room({kChair});
  room.Track(0, 0, Frames(0, 4));
  room.Track(1, 0, Frames(4, 4));
  loop::LoopOptions loops;
  loops.enabled = false;
  loops.merge_overlapping = false;
  const Result<ClosedMap> closed = Close(room, loops);
  ASSERT_TRUE(closed.ok());
  EXPECT_THAT(closed->loops.merges, IsEmpty());
  EXPECT_THAT(Ids(closed->map), ElementsAre(0, 1));
}

TEST(CloseLoops, SameInputSameResultOnAnyNumberOfThreads) {
  std::vector<Result<ClosedMap>> results;
  for (const int num_threads : {1, 4}) {
    const ThreadLimit limit(num_threads);
    ModelledRoom room({kChair, kOther}, Yawed(0.3, -0.2, 0.03));
    room.Track(0, 0, kFirst);
    room.Track(1, 1, kFirst);
    room.Track(2, 0, kSecond);
    room.Track(3, 1, kSecond);
    results.push_back(Close(room));
    ASSERT_TRUE(results.back().ok());
  }
  const ClosedMap& one = *results[0];
  const ClosedMap& four = *results[1];
  ASSERT_EQ(Ids(one.map), Ids(four.map));
  for (std::size_t n = 0; n < one.map.objects.size(); ++n) {
    EXPECT_EQ(one.map.objects[n].world_from_object, four.map.objects[n].world_from_object);
    EXPECT_EQ(one.map.objects[n].confidence, four.map.objects[n].confidence);
  }
}

// What comes of the made: completed anew by both traversals' views.
TEST(CloseLoops, WhatWasCompletedForAMergedObjectComesWithItsModel) {
  ModelledRoom room({kChair});
  room.Track(0, 0, Frames(0, 4));
  room.Track(1, 0, Frames(4, 4));
  const Result<ClosedMap> closed = Close(room, {}, {});
  ASSERT_TRUE(closed.ok()) << closed.error().message;
  ASSERT_FALSE(closed->made.candidates.empty());
  std::set<int> ids;
  for (const ShapeCandidate& candidate : closed->made.candidates) {
    EXPECT_TRUE(closed->made.models.contains(candidate.model)) << candidate.model;
    EXPECT_EQ(candidate.object, ObjectId{0});
    EXPECT_THAT(candidate.model, HasSubstr("merged_"));
    EXPECT_TRUE(ids.insert(candidate.id.value).second) << "numbers are not given twice";
  }
}

TEST(CloseLoops, AModelThatIsMissingIsNamed) {
  ModelledRoom room({kChair});
  room.Track(0, 0, Frames(0, 4));
  room.Track(1, 0, Frames(4, 4));
  const Result<Selection> selection = room.Select(AsProposed());
  ASSERT_TRUE(selection.ok());
  room.models.grids.clear();
  const FrameViews views = room.Views();
  const ObjectSources sources{views, room.models, room.prepared, room.progress};
  const ObjectOptions objects = AsProposed();
  const Result<ClosedMap> closed =
      CloseLoops(MapOf(room, *selection), {sources, {}, objects, {}, {}});
  ASSERT_FALSE(closed.ok());
  EXPECT_EQ(closed.error().code, ErrorCode::kInvalidInput);
  EXPECT_THAT(closed.error().message, HasSubstr("item_0"));
}

TEST(CloseLoops, EndsWhenAskedTo) {
  ModelledRoom room({kChair});
  room.Track(0, 0, kFirst);
  const Result<Selection> selection = room.Select(AsProposed());
  ASSERT_TRUE(selection.ok());
  room.progress.stop = true;
  const FrameViews views = room.Views();
  const ObjectSources sources{views, room.models, room.prepared, room.progress};
  const ObjectOptions objects = AsProposed();
  const Result<ClosedMap> closed =
      CloseLoops(MapOf(room, *selection), {sources, {}, objects, {}, {}});
  ASSERT_FALSE(closed.ok());
  EXPECT_EQ(closed.error().code, ErrorCode::kInterrupted);
}

TEST(CloseLoops, OfNothingIsNothing) {
  ModelledRoom room({kChair});
  const Result<ClosedMap> closed = Close(room);
  ASSERT_TRUE(closed.ok()) << closed.error().message;
  EXPECT_THAT(closed->map.objects, IsEmpty());
  EXPECT_THAT(closed->loops.constellations, IsEmpty());
}

}  // namespace
}  // namespace deepslam::modelling
