// Objects of a furnished room from proposals to winners: which candidate wins, and what does where
// something is missing.
#include "deepslam/modelling/select_objects.h"

#include <algorithm>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "modelling/furnished_room.h"
#include "support/pose_matchers.h"

namespace deepslam::modelling {
namespace {

using ::deepslam::testing_support::BlockGrid;
using ::deepslam::testing_support::ChairGrid;
using ::deepslam::testing_support::PoseNear;
using ::deepslam::testing_support::StoolGrid;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing_support::Frames;
using testing_support::Furniture;
using testing_support::ModelledRoom;

const Furniture kChair = {"chair", ChairGrid(), 0.9, 0.0, -0.3, 0.4};

// Without what stands above the seat.
VoxelGrid SeatGrid() {
  VoxelGrid seat = ChairGrid();
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = kGridSize / 2; k < kGridSize; ++k) seat.occupied[VoxelGrid::Index(i, j, k)] = 0;
    }
  }
  return seat;
}

TEST(SelectObjects, TheTrueShapeWinsWhereItStands) {
  ModelledRoom room({kChair});
  room.Track(0, 0, Frames(0, 6));
  room.AddCandidate(0, "block", BlockGrid(), 0.9);
  room.AddCandidate(0, "stool", StoolGrid(), 0.9);
  ObjectOptions options;
  options.refinement.complete = false;
  const Result<Selection> selection = room.Select(options);
  ASSERT_TRUE(selection.ok()) << selection.error().message;
  ASSERT_EQ(selection->map.objects.size(), 1U);
  const MapObject& chair = selection->map.objects[0];
  EXPECT_EQ(chair.model, "item_0");
  EXPECT_EQ(chair.scores.size(), 3U);
  EXPECT_THAT(chair.world_from_object, PoseNear(room.room.truth(0).RigidPart(), 0.03, 3));
  EXPECT_NEAR(chair.scale_m / room.room.truth(0).scale, 1.0, 0.05);
  EXPECT_GT(chair.confidence, 0);
  EXPECT_THAT(selection->made.candidates, IsEmpty());
}

// The only design has a back that is not there: completed by what was measured it wins.
TEST(SelectObjects, ACompletedCandidateReplacesTheOneItIsMadeOf) {
  ModelledRoom room({{"chair", SeatGrid(), 0.9, 0.0, -0.3, 0.4}});
  room.Track(0, 0, Frames(0, 8));
  room.proposals.candidates[0].model = "with_back";
  room.models.grids = {{"with_back", ChairGrid()}};
  const Result<Selection> selection = room.Select();
  ASSERT_TRUE(selection.ok()) << selection.error().message;
  ASSERT_EQ(selection->map.objects.size(), 1U);
  const MapObject& seat = selection->map.objects[0];
  EXPECT_EQ(seat.source, CandidateSource::kCompleted);
  EXPECT_EQ(seat.model, "filled_000_0");
  ASSERT_EQ(selection->made.candidates.size(), 1U);
  EXPECT_EQ(seat.chosen, selection->made.candidates[0].id);
  EXPECT_EQ(seat.chosen, CandidateId{1}) << "numbered behind the proposed";
  EXPECT_TRUE(selection->made.models.contains(seat.model));
  ASSERT_EQ(selection->made_registrations.size(), 1U);
  EXPECT_EQ(selection->made_registrations[0].candidate, seat.chosen);
  ASSERT_EQ(seat.scores.size(), 2U);
  EXPECT_GT(seat.scores[0].score, seat.scores[1].score);
}

TEST(SelectObjects, ARefinedPoseReplacesTheProposedRegistration) {
  ModelledRoom room({kChair});
  room.Track(0, 0, Frames(0, 6));
  ObjectOptions options;
  options.refinement.complete = false;
  ASSERT_TRUE(room.Select(options).ok());
  // It was registered beside its place.
  CandidateRegistration& placed = room.registrations[0];
  placed.world_from_object.translation_m.x() += 0.05;
  for (ViewRegistration& view : placed.views) view.ok = false;
  options.refinement.pose = true;
  const FrameViews views = room.Views();
  const ObjectSources sources{views, room.models, room.prepared, room.progress};
  const Result<Selection> selection =
      SelectObjects(room.Objects(), {room.proposals, room.registrations}, sources, options);
  ASSERT_TRUE(selection.ok()) << selection.error().message;
  ASSERT_EQ(selection->made_registrations.size(), 1U);
  EXPECT_EQ(selection->made_registrations[0].candidate, CandidateId{0});
  ASSERT_EQ(selection->map.objects.size(), 1U);
  EXPECT_THAT(selection->map.objects[0].world_from_object,
              PoseNear(room.room.truth(0).RigidPart(), 0.02, 2));
}

TEST(SelectObjects, WhatAPersonChoseWins) {
  ModelledRoom room({kChair});
  room.Track(0, 0, Frames(0, 6));
  room.AddCandidate(0, "armless", ChairGrid(), 0.8);  // smaller than it is: scores worse
  ObjectOptions options;
  options.refinement.complete = false;
  options.choice = {"choices.yaml",
                    [](ObjectId, auto) -> Result<CandidateId> { return CandidateId{1}; }};
  const Result<Selection> selection = room.Select(options);
  ASSERT_TRUE(selection.ok()) << selection.error().message;
  ASSERT_EQ(selection->map.objects.size(), 1U);
  EXPECT_EQ(selection->map.objects[0].model, "armless");
  EXPECT_THAT(selection->map.objects[0].note, HasSubstr("chosen by hand"));
  EXPECT_THAT(selection->applied, ElementsAre(HasSubstr("object 0 is candidate 1 (armless)")));
  options.choice.choose = [](ObjectId, auto) -> Result<CandidateId> {
    return InvalidConfig("no candidate \"throne\"");
  };
  EXPECT_EQ(room.Select(options).error().message, "no candidate \"throne\"");
}

// What nobody named has to be explained well; its votes go into the map.
TEST(SelectObjects, WhatNobodyNamedAndNothingExplainsIsDropped) {
  ModelledRoom room({kChair});
  room.Track(0, 0, Frames(0, 6));
  ObjectOptions options;
  options.select.min_unnamed_confidence = 1;  // nothing is explained that well
  Result<Selection> selection = room.Select(options);
  ASSERT_TRUE(selection.ok()) << selection.error().message;
  ASSERT_EQ(selection->map.objects.size(), 1U) << "a detector called it a chair";
  EXPECT_EQ(selection->map.objects[0].class_votes, room.association.tracks[0].class_votes);
  room.association.tracks[0].class_votes = {{"table", 0.2}};
  selection = room.Select(options);
  ASSERT_TRUE(selection.ok());
  EXPECT_THAT(selection->map.objects, IsEmpty());
  EXPECT_THAT(selection->map.dropped, ElementsAre(HasSubstr("no detection names it")));
  options.select.min_unnamed_confidence = 0;
  EXPECT_EQ(room.Select(options)->map.objects.size(), 1U);
}

// Where priors are at work, two views of what none of them knows are no shape.
TEST(SelectObjects, WhatIsMeasuredAloneNeedsThreeViews) {
  ObjectOptions options;
  options.refinement.complete = false;
  const auto num_mapped = [&](int num_views, bool with_priors) {
    ModelledRoom room({kChair});
    room.Track(0, 0, Frames(0, 6));
    room.Track(1, 0, Frames(0, num_views));
    for (ShapeCandidate& candidate : room.proposals.candidates) {
      if (candidate.object == ObjectId{1} || !with_priors)
        candidate.source = CandidateSource::kFused;
    }
    const Result<Selection> selection = room.Select(options);
    EXPECT_TRUE(selection.ok());
    return selection->map.objects.size();
  };
  EXPECT_EQ(num_mapped(2, true), 1U);
  EXPECT_EQ(num_mapped(3, true), 2U);
  EXPECT_EQ(num_mapped(2, false), 2U) << "without priors a measurement is all there is";
}

TEST(SelectObjects, AnObjectWithoutViewsIsDroppedWithTheReason) {
  ModelledRoom room({kChair});
  room.Track(0, 0, Frames(0, 6));
  room.Track(1, 0, {});
  for (const int frame : Frames(0, 6)) room.room.broken.insert(frame);
  const Result<Selection> selection = room.Select();
  ASSERT_TRUE(selection.ok()) << selection.error().message;
  EXPECT_THAT(selection->map.objects, IsEmpty());
  EXPECT_THAT(selection->map.dropped,
              ElementsAre(HasSubstr("chair_00: "), HasSubstr("chair_01: ")));
  EXPECT_FALSE(room.progress.warnings.empty()) << "frames that cannot be read are told of";
}

TEST(SelectObjects, AnObjectWithoutCandidatesIsDropped) {
  ModelledRoom room({kChair});
  room.Track(0, 0, Frames(0, 6));
  room.proposals = {};
  const Result<Selection> selection = room.Select();
  ASSERT_TRUE(selection.ok());
  EXPECT_THAT(selection->map.dropped, ElementsAre(HasSubstr("chair_00: ")));
}

TEST(SelectObjects, AModelThatIsMissingIsNamed) {
  ModelledRoom room({kChair});
  room.Track(0, 0, Frames(0, 3));
  room.models.grids.clear();
  const Result<Selection> selection = room.Select();
  ASSERT_FALSE(selection.ok());
  EXPECT_THAT(selection.error().message, HasSubstr("item_0"));
}

TEST(SelectObjects, ACandidateThatWasNotRegisteredIsNamed) {
  ModelledRoom room({kChair});
  room.Track(0, 0, Frames(0, 3));
  const FrameViews views = room.Views();
  const ObjectSources sources{views, room.models, room.prepared, room.progress};
  const Result<Selection> selection =
      SelectObjects(room.Objects(), {room.proposals, {}}, sources, {});
  ASSERT_FALSE(selection.ok());
  EXPECT_THAT(selection.error().message, HasSubstr("candidate 0"));
}

TEST(SelectObjects, EndsWhenAskedTo) {
  ModelledRoom room({kChair});
  room.Track(0, 0, Frames(0, 3));
  room.progress.stop = true;
  const Result<Selection> selection = room.Select();
  ASSERT_FALSE(selection.ok());
  EXPECT_EQ(selection.error().code, ErrorCode::kInterrupted);
}

}  // namespace
}  // namespace deepslam::modelling
