#include "deepslam/select/select.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deepslam/select/confidence.h"
#include "deepslam/select/score.h"
#include "support/furniture_world.h"

namespace deepslam::select {
namespace {

using testing_support::CandidateFor;
using testing_support::FurnitureWorld;
using testing_support::PlacedAt;
using testing_support::ViewSettings;

// The same bottom, another scale.
Similarity3 Scaled(Similarity3 world_from_object, double factor) {
  world_from_object.scale *= factor;
  world_from_object.translation_m.z() *= factor;
  return world_from_object;
}

class ScoreOnAChair : public testing::Test {
 protected:
  double Score(const VoxelGrid& grid,
               const Similarity3& placed,
               const std::vector<ObjectView>& views) const {
    return ScoreCandidate(CandidateFor(0.5, 1.5),
                          shape::ShapeModel(grid),
                          PlacedAt(placed, views),
                          views,
                          options_)
        .score;
  }

  FurnitureWorld world_{testing_support::ChairGrid(), 0.9};
  std::vector<ObjectView> views_ = world_.Views({0.0, 0.7, 1.4, 2.1, 2.8});
  Similarity3 truth_ = world_.world_from_object();
  SelectOptions options_;
};

TEST_F(ScoreOnAChair, TheTrueModelInItsPlaceIsNearOne) {
  EXPECT_GT(Score(testing_support::ChairGrid(), truth_, views_), 0.95);
}

TEST_F(ScoreOnAChair, EveryWrongSizeScoresLess) {
  const double best = Score(testing_support::ChairGrid(), truth_, views_);
  double last = best;
  for (const double factor : {1.1, 1.2, 1.4}) {
    const double score = Score(testing_support::ChairGrid(), Scaled(truth_, factor), views_);
    EXPECT_LT(score, last) << factor;
    last = score;
  }
  last = best;
  for (const double factor : {0.9, 0.8, 0.6}) {
    const double score = Score(testing_support::ChairGrid(), Scaled(truth_, factor), views_);
    EXPECT_LT(score, last) << factor;
    last = score;
  }
}

TEST_F(ScoreOnAChair, AShiftedOrTurnedModelScoresLess) {
  const double best = Score(testing_support::ChairGrid(), truth_, views_);
  Similarity3 shifted = truth_;
  shifted.translation_m.y() += 0.1;
  EXPECT_LT(Score(testing_support::ChairGrid(), shifted, views_), best - 0.1);
  Similarity3 turned = truth_;
  turned.rotation = Eigen::AngleAxisd(1.57, Eigen::Vector3d::UnitZ()) * turned.rotation;
  EXPECT_LT(Score(testing_support::ChairGrid(), turned, views_), best - 0.1);
}

TEST_F(ScoreOnAChair, AFilledHullOrAnotherShapeScoresLess) {
  const double best = Score(testing_support::ChairGrid(), truth_, views_);
  EXPECT_LT(Score(testing_support::BlockGrid(), truth_, views_), best - 0.2);
  EXPECT_LT(Score(testing_support::StoolGrid(), truth_, views_), best - 0.2);
  EXPECT_LT(Score(testing_support::ChairGrid(0.3), truth_, views_), best - 0.05);
}

TEST_F(ScoreOnAChair, SolidPartsInFreeSpaceAreCountedAsViolation) {
  const auto violation = [&](const VoxelGrid& grid) {
    return ScoreCandidate(CandidateFor(0.5, 1.5),
                          shape::ShapeModel(grid),
                          PlacedAt(truth_, views_),
                          views_,
                          options_)
        .free_violation;
  };
  EXPECT_LT(violation(testing_support::ChairGrid()), 0.02);
  EXPECT_GT(violation(testing_support::BlockGrid()), 0.1);
}

TEST_F(ScoreOnAChair, WhatHidesTheObjectSpeaksNeitherForNorAgainstIt) {
  ViewSettings hidden;
  hidden.occluded_share = 0.4;
  const std::vector<ObjectView> views = world_.Views({0.0, 0.7, 1.4, 2.1, 2.8}, hidden);
  EXPECT_GT(Score(testing_support::ChairGrid(), truth_, views), 0.95);
}

TEST_F(ScoreOnAChair, AModelInTheAirScoresLessThanWereThereNoGround) {
  Similarity3 lifted = truth_;
  lifted.translation_m.z() += 0.2;
  std::vector<ObjectView> groundless = views_;
  for (ObjectView& view : groundless) view.ground_camera.reset();
  const CandidateScore score = ScoreCandidate(
      CandidateFor(0.5, 1.5), world_.model(), PlacedAt(lifted, views_), views_, options_);
  EXPECT_THAT(score.note, testing::HasSubstr("above the ground"));
  EXPECT_LT(score.score, 0.5 * Score(testing_support::ChairGrid(), lifted, groundless));
}

// As much as floors are unsure by costs nothing; more costs what one source has before another.
TEST_F(ScoreOnAChair, FiveCentimetresAboveTheGroundCostAndTwoDoNot) {
  std::vector<ObjectView> groundless = views_;
  for (ObjectView& view : groundless) view.ground_camera.reset();
  const auto share_left = [&](double lift_m) {
    Similarity3 lifted = truth_;
    lifted.translation_m.z() += lift_m;
    return Score(testing_support::ChairGrid(), lifted, views_) /
           Score(testing_support::ChairGrid(), lifted, groundless);
  };
  EXPECT_EQ(share_left(0.02), 1);
  EXPECT_LT(share_left(0.05), 0.985);
}

// A candidate cannot gain by refusing the views that speak against it.
TEST_F(ScoreOnAChair, RefusedViewsAreJudgedAtTheJointPose) {
  const shape::ShapeModel block(testing_support::BlockGrid());
  CandidateRegistration all = PlacedAt(truth_, views_);
  CandidateRegistration one = all;
  for (std::size_t i = 1; i < one.views.size(); ++i) one.views[i].ok = false;
  const ShapeCandidate candidate = CandidateFor(0.5, 1.5);
  EXPECT_NEAR(ScoreCandidate(candidate, block, one, views_, options_).score,
              ScoreCandidate(candidate, block, all, views_, options_).score,
              1e-9);
}

TEST(ScoreOf, IsTheHarmonicMeanAndBounded) {
  EXPECT_NEAR(ScoreOf({0.5, 0.5, 0, 1}, 0), 0.5, 1e-12);
  EXPECT_LT(ScoreOf({1.0, 0.2, 0, 1}, 0), 0.5 * (1.0 + 0.2));
  EXPECT_EQ(ScoreOf({0, 0, 0, 0}, 0), 0);
  EXPECT_EQ(ScoreOf({1, 1, 0, 1}, std::numeric_limits<double>::quiet_NaN()), 0);
  EXPECT_LT(ScoreOf({1, 1, 0, 1}, 0.2), ScoreOf({1, 1, 0, 1}, 0.05));
}

// Three candidates for one chair: a block from view 0, the chair from view 2, a fused measurement.
class SelectAChair : public testing::Test {
 protected:
  SelectAChair() {
    Add(testing_support::BlockGrid(), 0, CandidateSource::kRetrieval);
    Add(testing_support::ChairGrid(), 2, CandidateSource::kRetrieval);
  }

  void Add(const VoxelGrid& grid, int view, CandidateSource source) {
    ShapeCandidate candidate = CandidateFor(0.5, 1.5, 0, static_cast<int>(candidates_.size()));
    candidate.view = DetectionId{view};
    candidate.source = source;
    registrations_.push_back(PlacedAt(world_.world_from_object(), views_, candidate.id.value));
    scores_.push_back(ScoreCandidate(
        candidate, shape::ShapeModel(grid), registrations_.back(), views_, options_));
    candidates_.push_back(candidate);
  }

  // Instead of all: the chair as a product, and from another source, seen from these azimuths.
  void SeeProductAnd(CandidateSource other, const std::vector<double>& azimuths_rad) {
    views_ = world_.Views(azimuths_rad);
    candidates_.clear();
    registrations_.clear();
    scores_.clear();
    Add(testing_support::ChairGrid(), 0, CandidateSource::kRetrieval);
    Add(testing_support::ChairGrid(), -1, other);
  }

  [[nodiscard]] MapObject Select() const {
    return SelectShape(
        ObjectId{3}, "chair", candidates_, registrations_, scores_, views_, options_);
  }

  [[nodiscard]] double ConfidenceOf(const MapObject& object) const {
    return Confidence(object, world_.model(), candidates_, registrations_, scores_);
  }

  FurnitureWorld world_{testing_support::ChairGrid(), 0.9};
  std::vector<ObjectView> views_ = world_.Views({0.0, 0.7, 1.4, 2.1, 2.8});
  SelectOptions options_;
  std::vector<ShapeCandidate> candidates_;
  std::vector<CandidateRegistration> registrations_;
  std::vector<CandidateScore> scores_;
};

TEST_F(SelectAChair, TheChairWinsAndTheHistoryTellsWhen) {
  const MapObject object = Select();
  EXPECT_EQ(object.chosen, CandidateId{1});
  EXPECT_EQ(object.id, ObjectId{3});
  EXPECT_EQ(object.class_name, "chair");
  EXPECT_EQ(object.scale_m, registrations_[1].scale_m);
  EXPECT_EQ(object.views.size(), views_.size());
  EXPECT_EQ(object.scores.front().candidate, CandidateId{1});
  ASSERT_EQ(object.history.size(), 2u);
  EXPECT_EQ(object.history[0].candidate, CandidateId{0});
  EXPECT_EQ(object.history[0].frame, views_[0].frame);
  EXPECT_EQ(object.history[1].candidate, CandidateId{1});
  EXPECT_EQ(object.history[1].frame, views_[2].frame);
  EXPECT_GT(ConfidenceOf(object), 0.8);
}

TEST_F(SelectAChair, GreedyTakesTheLastOfTheHistory) {
  options_.mode = "greedy";
  const MapObject object = Select();
  EXPECT_EQ(object.chosen, object.history.back().candidate);
}

TEST_F(SelectAChair, AFusedShapeMustBeClearlyBetter) {
  Add(testing_support::ChairGrid(), -1, CandidateSource::kFused);
  EXPECT_EQ(Select().source, CandidateSource::kRetrieval);
  registrations_[1].ok = false;  // only the block is left to compete
  EXPECT_EQ(Select().source, CandidateSource::kFused);
  EXPECT_THAT(Select().note, testing::HasSubstr("made of the measurement"));
}

TEST_F(SelectAChair, LeavesOutWhatIsSmallerThanTheMapHolds) {
  const double size_m = registrations_[1].scale_m * kModelExtent;
  options_.min_size_m = 1.01 * size_m;
  EXPECT_FALSE(Select().chosen.valid());
  EXPECT_THAT(Select().note, testing::HasSubstr("cm large, less than select.min_size_m"));
  options_.min_size_m = 0.99 * size_m;
  EXPECT_TRUE(Select().chosen.valid());
}

// What nobody saw is missing from a fused shape: seen all round it needs a small lead, from one
// side a large one.
TEST_F(SelectAChair, AFusedShapeSeenAllRoundMayWinByLess) {
  const auto fused_wins = [&](const std::vector<double>& azimuths_rad, double lead) {
    SeeProductAnd(CandidateSource::kFused, azimuths_rad);
    scores_[0].score = 0.85;
    scores_[1].score = scores_[0].score + lead;
    return Select().source == CandidateSource::kFused;
  };
  const std::vector<double> all_round = {0.0, 1.5, 3.0, 4.5};
  const std::vector<double> one_side = {0.0, 0.2, 0.4};
  EXPECT_TRUE(fused_wins(all_round, 0.1));
  EXPECT_FALSE(fused_wins(one_side, 0.1));
  // Within what noise and voxels take off a true model's score nothing is said.
  EXPECT_FALSE(fused_wins(all_round, 0.02));
}

// Among many products one fits by chance what little was seen.
TEST_F(SelectAChair, ACataloguesProductNeedsALeadOverANetworkWhereOneSideWasSeen) {
  const auto network_wins = [&](const std::vector<double>& azimuths_rad, double behind) {
    SeeProductAnd(CandidateSource::kNetwork, azimuths_rad);
    scores_[0].score = 0.9;
    scores_[1].score = scores_[0].score - behind;
    return Select().source == CandidateSource::kNetwork;
  };
  EXPECT_TRUE(network_wins({0.0, 0.2, 0.4}, 0.01));
  EXPECT_FALSE(network_wins({0.0, 0.2, 0.4}, 0.03));
  EXPECT_FALSE(network_wins({0.0, 1.5, 3.0, 4.5}, 0.01));
}

TEST_F(SelectAChair, OfEqualScoresAFreeFrontDecidesAndNoWallAgainstTheDepth) {
  const auto winner = [&](double lead) {
    scores_[0].score = 0.9 + lead;
    scores_[1].score = 0.9;
    scores_[0].front_blocked = 1;
    return Select().chosen;
  };
  EXPECT_EQ(winner(0), CandidateId{1});
  EXPECT_EQ(winner(0.01), CandidateId{1});
  EXPECT_EQ(winner(0.09), CandidateId{0});
}

// Two chairs cut out as one: the fused shape explains both, the right model of the one all that is
// near it.
TEST_F(SelectAChair, DepthOutOfAWholeModelsReachDoesNotSpeakForAFusedShape) {
  Add(testing_support::ChairGrid(), -1, CandidateSource::kFused);
  views_ = world_.Views({0.0, 1.5, 3.0, 4.5});
  const auto fused_wins = [&](double reached, double lead) {
    CandidateScore& whole = scores_[1];
    whole.surface_share = 0.66;
    whole.coverage_share = 0.98;
    whole.reached_share = reached;
    whole.score = ScoreOf({whole.surface_share, whole.coverage_share, 0, 4}, 0);
    scores_[2].score = whole.score + lead;
    scores_[0].score = 0;
    return Select().source == CandidateSource::kFused;
  };
  EXPECT_TRUE(fused_wins(1.0, 0.18));    // the model is poor where it stands
  EXPECT_FALSE(fused_wins(0.67, 0.18));  // what is missing lies elsewhere
  EXPECT_TRUE(fused_wins(0.67, 0.26));   // so far ahead, whatever it is
}

TEST_F(ScoreOnAChair, DepthFarFromTheModelIsOutOfItsReach) {
  const shape::ShapeModel chair{testing_support::ChairGrid()};
  const auto scored = [&](double shift_m) {
    Similarity3 placed = truth_;
    placed.translation_m.x() += shift_m;
    return ScoreCandidate(
        CandidateFor(0.5, 1.5), chair, PlacedAt(placed, views_), views_, options_);
  };
  const CandidateScore there = scored(0);
  EXPECT_GT(there.reached_share, 0.99);
  EXPECT_NEAR(ScoreWithinReach(there), there.score, 0.01);
  const CandidateScore beside = scored(0.4);
  EXPECT_LT(beside.reached_share, 0.8);
  EXPECT_GT(beside.reached_share, beside.surface_share);
  EXPECT_GT(ScoreWithinReach(beside), beside.score);
  EXPECT_LT(ScoreWithinReach(beside), there.score);
  EXPECT_LT(scored(3.0).reached_share, 0.01);
  EXPECT_EQ(ScoreWithinReach(scored(3.0)), scored(3.0).score);
}

TEST_F(SelectAChair, WhatMostViewsPullAwayLosesToWhatTheyConfirm) {
  ASSERT_EQ(Select().chosen, CandidateId{1});
  for (std::size_t i = 0; i + 1 < views_.size(); ++i) registrations_[1].views[i].ok = false;
  EXPECT_EQ(Select().chosen, CandidateId{0});
  options_.mode = "greedy";
  EXPECT_EQ(Select().chosen, CandidateId{0});
  EXPECT_EQ(Select().history.size(), 1U);
}

TEST_F(SelectAChair, SaysWhyWherePlacedCandidatesAgreeWithNothing) {
  for (CandidateScore& score : scores_) score.score = 0;
  const MapObject object = Select();
  EXPECT_FALSE(object.chosen.valid());
  EXPECT_THAT(object.note, testing::HasSubstr("none agrees with the depth"));
}

TEST_F(SelectAChair, OfTwoThatAgreeAlikeTheOneThatFacesTheCamerasWins) {
  Add(testing_support::ChairGrid(), 0, CandidateSource::kRetrieval);
  const std::size_t last = candidates_.size() - 1;
  scores_[last] = scores_[1];
  scores_[last].candidate = candidates_[last].id;
  scores_[last].score += 0.005;
  scores_[1].score -= 0.005;
  EXPECT_EQ(Select().chosen, candidates_[last].id);
  // The true placement faces the cameras; turned round it shows them its back.
  Eigen::Quaterniond& rotation = registrations_[last].world_from_object.rotation;
  rotation = Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()) * rotation;
  EXPECT_EQ(Select().chosen, CandidateId{1});
}

TEST_F(SelectAChair, OneSideGivesLessConfidenceAndSaysSo) {
  const double all_round = ConfidenceOf(Select());
  views_.resize(1);
  registrations_.clear();
  scores_.clear();
  candidates_.clear();
  Add(testing_support::ChairGrid(), 0, CandidateSource::kRetrieval);
  const MapObject object = Select();
  EXPECT_LT(ConfidenceOf(object), all_round);
  EXPECT_THAT(object.note, testing::HasSubstr("one side"));
}

TEST_F(SelectAChair, SaysWhenTheYawCannotBeTold) {
  for (ViewRegistration& view : registrations_[1].views) view.yaw_free = true;
  EXPECT_THAT(Select().note, testing::HasSubstr("rotation about the vertical"));
}

TEST_F(SelectAChair, WithoutAPlacedCandidateThereIsNoWinner) {
  for (CandidateRegistration& registration : registrations_) {
    registration.ok = false;
    registration.reason = "too few points";
  }
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    scores_[i] =
        ScoreCandidate(candidates_[i], world_.model(), registrations_[i], views_, options_);
    EXPECT_EQ(scores_[i].score, 0);
  }
  const MapObject object = Select();
  EXPECT_FALSE(object.chosen.valid());
  EXPECT_EQ(ConfidenceOf(object), 0);
  EXPECT_THAT(object.note, testing::HasSubstr("too few points"));
  EXPECT_FALSE(SelectShape(ObjectId{0}, "chair", {}, {}, {}, {}, options_).chosen.valid());
}

TEST(ScoreCandidate, StaysFiniteOnWhatTellsNothing) {
  const FurnitureWorld world(testing_support::ChairGrid(), 0.9);
  ObjectView blind = world.View(0, 0.2, {});
  for (float& depth : blind.depth_crop_m) depth = std::numeric_limits<float>::quiet_NaN();
  const std::vector<ObjectView> views = {ObjectView(), blind};
  CandidateRegistration nowhere = PlacedAt(world.world_from_object(), views);
  for (ViewRegistration& view : nowhere.views) {
    view.camera_from_object.translation_m.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  const ShapeCandidate candidate = CandidateFor(0.5, 1.5);
  for (const CandidateRegistration& registration :
       {PlacedAt(world.world_from_object(), views), nowhere, CandidateRegistration()}) {
    for (const VoxelGrid& grid :
         {testing_support::ChairGrid(), VoxelGrid(), testing_support::FullGrid()}) {
      const CandidateScore score =
          ScoreCandidate(candidate, shape::ShapeModel(grid), registration, views, {});
      EXPECT_TRUE(std::isfinite(score.score));
      EXPECT_LT(score.score, 0.1);
    }
  }
}

}  // namespace
}  // namespace deepslam::select
