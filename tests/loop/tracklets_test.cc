#include "deepslam/loop/tracklets.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "loop/synthetic_traversals.h"
#include "support/pose_matchers.h"

namespace deepslam::loop {
namespace {

using ::deepslam::testing_support::PoseNear;
using testing_support::AddTraversal;
using testing_support::ChairPoints;
using testing_support::Clutter;
using testing_support::Detect;
using testing_support::Furniture;
using testing_support::Merged;
using testing_support::Moved;
using testing_support::Scene;
using testing_support::Walk;
using testing_support::Yawed;

using Points = std::vector<Eigen::Vector3f>;
using Merges = std::set<std::pair<int, int>>;

const Eigen::Vector3d kUp = Eigen::Vector3d::UnitZ();

ObjectTrack Track(int id, const std::vector<int>& frames) {
  ObjectTrack track{ObjectId{id}, "chair", {}, ""};
  for (const int frame : frames)
    track.members.push_back({DetectionId{frame}, FrameIdx{frame}, 0, 0, "vote"});
  return track;
}

ObjectEvidence Measured(const Points& object, const Points& around = {}) {
  return {object, {}, around};
}

bool ChairStandsApart(const Pose3& second_from_first) {
  return StandApart(
      Measured(ChairPoints()), Measured(Moved(ChairPoints(), second_from_first)), kUp, {});
}

// A level board that begins at x, 0.75 m up.
Points Top(float x_m, float length_m) {
  Points points;
  for (float a = 0; a < length_m; a += 0.02F) {
    for (float y = 0; y < 0.8F; y += 0.02F) points.emplace_back(x_m + a, y, 0.75F);
  }
  return points;
}

// Each but the first against the one before.
std::vector<bool> Apart(const std::vector<ObjectEvidence>& tracklets) {
  std::vector<bool> apart;
  for (std::size_t k = 1; k < tracklets.size(); ++k)
    apart.push_back(StandApart(tracklets[k - 1], tracklets[k], kUp, {}));
  return apart;
}

TEST(Tracklets, EndWhereTheObjectIsNotSeenForLong) {
  const LoopOptions options;  // 30 frames
  const std::vector<ObjectTrack> tracklets = Tracklets(Track(7, {0, 29, 58, 88, 90, 200}), options);
  ASSERT_EQ(tracklets.size(), 3U);
  EXPECT_EQ(tracklets[0].members.size(), 3U);
  EXPECT_EQ(tracklets[1].members.size(), 2U);
  EXPECT_EQ(tracklets[2].members.front().frame, FrameIdx{200});
  for (const ObjectTrack& tracklet : tracklets) EXPECT_EQ(tracklet.id, ObjectId{7});
}

TEST(Tracklets, StandApartWhereTheyFitElsewhere) {
  EXPECT_TRUE(ChairStandsApart(Yawed(0.25, -0.1, 0, 0.05)));
  EXPECT_TRUE(ChairStandsApart(Yawed(0, 0.2, 0, -0.1)));
  EXPECT_FALSE(ChairStandsApart({}));
  EXPECT_FALSE(ChairStandsApart(Yawed(0.05, -0.03, 0.02, 0.05)));
}

TEST(Tracklets, OfWhichTooLittleIsComparedDoNotStandApart) {
  EXPECT_FALSE(ChairStandsApart(Yawed(3, 0, 0, 0)));
  const ObjectEvidence away = Measured(Moved(ChairPoints(), Yawed(0.25, 0, 0, 0)));
  Points few = ChairPoints();
  few.resize(29);
  EXPECT_FALSE(StandApart(Measured(few), away, kUp, {}));
  EXPECT_FALSE(StandApart(Measured({}), away, kUp, {}));
  EXPECT_FALSE(StandApart(away, Measured({}), kUp, {}));
}

// Of a long table either traversal saw another part, and alone these fit when one slides onto the
// other.
TEST(Tracklets, OfDifferentPartsAreToldByWhatStandsAround) {
  const Points room = Moved(Clutter(1, 1.5), Yawed(0, 0, 0.3, 0));
  const Points left = Top(0, 0.8F), right = Top(0.25F, 0.8F);
  EXPECT_TRUE(StandApart(Measured(Top(0, 0.8F)), Measured(Top(0.25F, 0.8F)), kUp, {}));
  EXPECT_FALSE(StandApart(Measured(left, room), Measured(right, room), kUp, {}));
  const Pose3 drift = Yawed(0.2, 0.15, 0, 0.03);
  EXPECT_TRUE(
      StandApart(Measured(left, room), Measured(Moved(left, drift), Moved(room, drift)), kUp, {}));
}

// Of a top that is seen nearly whole both times either end may be missing.
TEST(Tracklets, DoNotStandApartForLittle) {
  EXPECT_FALSE(StandApart(Measured(Top(0, 2.0F)), Measured(Top(0.15F, 2.0F)), kUp, {}));
  EXPECT_TRUE(StandApart(Measured(Top(0, 0.5F)), Measured(Top(0.15F, 0.5F)), kUp, {}));
}

TEST(Tracklets, AreCountedBehindTheLastId) {
  const Association association{
      {Track(2, {0, 1, 100, 101, 200, 201}), Track(4, {0, 100}), Track(9, {0, 100})}, {}};
  const Points there = ChairPoints();
  const Points away = Moved(there, Yawed(0.25, 0, 0, 0));
  const StandingApart apart = {
      {ObjectId{2}, Apart({Measured(there), Measured(away), Measured(away)})},
      {ObjectId{4}, Apart({Measured(there), Measured(there)})}};
  const SplitObjects parted = SplitTracklets(association, apart, {});
  ASSERT_EQ(parted.tracklets.size(), 2U);  // 4 stands still, of 9 nothing is known
  ASSERT_EQ(parted.tracks.size(), 2U);
  EXPECT_EQ(parted.tracklets[0].tracklet, ObjectId{2});
  EXPECT_EQ(parted.tracklets[0].last, FrameIdx{1});
  EXPECT_EQ(parted.tracklets[1].tracklet, ObjectId{10});
  EXPECT_EQ(parted.tracklets[1].object, ObjectId{2});
  EXPECT_EQ(parted.tracklets[1].first, FrameIdx{100});
  EXPECT_EQ(parted.tracks[1].id, ObjectId{10});
  EXPECT_EQ(parted.tracks[1].members.size(), 4U) << "the third traversal agrees with the second";
}

// Behind drift one chair was taken for the other: chair 0's track goes on with the second traversal
// of chair 1, as if no loop were there.
TEST(Tracklets, ANeighbourTakenForTheObjectIsGivenBack) {
  const std::vector<Furniture> chairs = {{"chair", 0, 0, 0.3}, {"chair", 0.75, 0.1, 0.5}};
  const auto room = Clutter(1, 4);
  Scene scene;
  scene.odometry = Walk(400, 20);
  AddTraversal(scene, chairs, 0, {}, room);
  AddTraversal(scene, chairs, 300, Yawed(-0.45, 0.05, 0, 0.02), room);
  EXPECT_EQ(Merged(Detect(scene)), (Merges{{0, 2}, {1, 3}}));

  Scene mistaken = scene;
  std::vector<ObjectTrack>& tracks = mistaken.association.tracks;
  std::ranges::copy(tracks[3].members, std::back_inserter(tracks[0].members));
  tracks.pop_back();
  mistaken.map.objects.pop_back();
  EXPECT_TRUE(Detect(mistaken).merges.empty());

  const auto seen = [&](int id) { return scene.evidence.at(ObjectId{id}); };
  const SplitObjects parted =
      SplitTracklets(mistaken.association, {{ObjectId{0}, Apart({seen(0), seen(3)})}}, {});
  ASSERT_EQ(parted.tracks.size(), 2U);
  EXPECT_EQ(parted.tracks[0].members.size(), scene.association.tracks[0].members.size());
  EXPECT_EQ(parted.tracks[1].id,
            ObjectId{3});  // what it is in the scene where nothing was mistaken
}

// One chair, seen before and after drift; whether another one was taken for it.
TEST(Tracklets, OfAReidentifiedObjectAreJoinedWhereDepthSaysSo) {
  const auto room = Clutter(1, 4);
  const Pose3 drift = Yawed(0.24, -0.1, 0, 0.05);
  for (const bool same_chair : {true, false}) {
    Scene scene;
    scene.odometry = Walk(400, 20);
    AddTraversal(scene, {{"chair", 0, 0, 0.3}}, 0, {}, room);
    AddTraversal(
        scene, {{"chair", same_chair ? 0 : -0.5, 0, same_chair ? 0.3 : 0.4}}, 300, drift, room);
    const std::vector<SplitTracklet> tracklets = {
        {ObjectId{0}, ObjectId{0}, FrameIdx{0}, FrameIdx{19}},
        {ObjectId{1}, ObjectId{0}, FrameIdx{300}, FrameIdx{319}}};
    std::vector<Constellation> proposed;
    const std::vector<Constellation> reidentified =
        ProposeReidentified(tracklets, scene.map, proposed);
    ASSERT_EQ(reidentified.size(), 1U);
    const Constellation verified =
        VerifyReidentified(reidentified.front(), scene.map, scene.evidence, {});
    EXPECT_EQ(verified.accepted, same_chair) << verified.reason;
    scene.evidence.at(ObjectId{1}).surroundings_world.clear();
    EXPECT_FALSE(VerifyReidentified(reidentified.front(), scene.map, scene.evidence, {}).accepted);
    if (!same_chair) continue;
    EXPECT_THAT(verified.old_world_from_new_world, PoseNear(drift.Inverse(), 0.05, 2.0));
  }
}

TEST(Tracklets, OfOneObjectLeaveItToAConstellationThatHasThem) {
  Scene scene;
  scene.odometry = Walk(400, 20);
  AddTraversal(scene, {{"chair", 0, 0, 0}, {"chair", 1, 0, 0}}, 0, {}, {});
  AddTraversal(scene, {{"chair", 0, 0, 0}, {"chair", 1, 0, 0}}, 300, {}, {});
  const ObjectId a{0}, b{1}, a2{2}, b2{3};
  const FrameIdx frame{5};
  const std::vector<SplitTracklet> tracklets = {
      {a, a, frame, frame}, {a2, a, frame, frame}, {b, b, frame, frame}, {b2, b, frame, frame}};
  Constellation both, overlap, other;
  both.pairs = {{a, a2}, {b, b2}};
  overlap.pairs = {{b, b2}};
  other.pairs = {{a, b}};

  std::vector<Constellation> proposed = {both, other};
  EXPECT_TRUE(ProposeReidentified(tracklets, scene.map, proposed).empty());
  EXPECT_EQ(proposed.size(), 2U);
  proposed = {overlap, other};
  EXPECT_EQ(ProposeReidentified(tracklets, scene.map, proposed).size(), 2U);
  EXPECT_EQ(proposed.size(), 1U);
  scene.map.objects.pop_back();  // b2 is another's meanwhile
  EXPECT_EQ(ProposeReidentified(tracklets, scene.map, proposed).size(), 1U);
}

TEST(Tracklets, GoBackWhereNobodyElseClaimedThem) {
  const auto tracklets_of = [](const std::vector<std::pair<int, int>>& pairs) {
    std::vector<SplitTracklet> tracklets;
    for (const auto& [tracklet, object] : pairs)
      tracklets.push_back({ObjectId{tracklet}, ObjectId{object}, FrameIdx{0}, FrameIdx{9}});
    return tracklets;
  };
  const auto as_merges = [](const RejoinedTracklets& rejoined) {
    Loops loops;
    loops.merges = rejoined.merges;
    return Merged(loops);
  };
  const std::vector<SplitTracklet> two = tracklets_of({{1, 1}, {7, 1}});
  const std::vector<SplitTracklet> three = tracklets_of({{1, 1}, {7, 1}, {8, 1}});
  const ObjectId a{1}, b{7}, c{8}, other{0};

  EXPECT_EQ(RejoinTracklets(two, {}).whole, (std::set<ObjectId>{a}));
  EXPECT_TRUE(RejoinTracklets(two, {{a, b}}).whole.empty());
  EXPECT_TRUE(RejoinTracklets(two, {{a, b}}).merges.empty());
  EXPECT_TRUE(RejoinTracklets(two, {{other, b}}).merges.empty()) << "it was another's";

  EXPECT_EQ(as_merges(RejoinTracklets(three, {{a, b}})), (Merges{{1, 8}}));
  EXPECT_EQ(as_merges(RejoinTracklets(three, {{b, c}})), (Merges{{1, 7}}));
  EXPECT_TRUE(RejoinTracklets(three, {{other, a}, {other, b}}).merges.empty());
}

TEST(Loops, AFurtherSearchGoesOnWhereTheFirstOneEnded) {
  const auto constellation = [](std::vector<ObjectMerge> pairs, bool accepted) {
    Constellation made;
    made.pairs = std::move(pairs);
    made.accepted = accepted;
    return made;
  };
  const ObjectId a{0}, b{1}, c{2}, d{3};
  Loops all;
  all.constellations = {constellation({{b, c}}, true), constellation({{a, d}}, false)};
  all.merges = {{b, c}};
  Loops more;
  more.constellations = {constellation({{a, d}}, true), constellation({{a, b}}, true)};
  more.merges = {{a, b}, {a, d}};
  Append(more, all);
  EXPECT_EQ(all.constellations.size(), 3U);
  EXPECT_TRUE(std::ranges::all_of(all.constellations, &Constellation::accepted));
  EXPECT_EQ(Merged(all), (Merges{{0, 1}, {0, 2}, {0, 3}}));
}

}  // namespace
}  // namespace deepslam::loop
