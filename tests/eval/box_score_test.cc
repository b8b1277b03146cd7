#include "deepslam/eval/box_score.h"

#include <numbers>
#include <vector>

#include <gmock/gmock.h>

#include "deepslam/core/random.h"

namespace deepslam::eval {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;

constexpr double kMinIou = 0.25;

PlacedBox Box(std::string class_name,
              const Eigen::Vector3d& middle_m,
              const Eigen::Vector3d& size_m,
              double yaw_deg = 0) {
  return {std::move(class_name),
          {Eigen::Quaterniond(
               Eigen::AngleAxisd(yaw_deg * std::numbers::pi / 180, Eigen::Vector3d::UnitZ())),
           middle_m},
          size_m};
}

TEST(BoxIou, IsThatOfSolids) {
  const PlacedBox unit = Box("a", {0, 0, 0}, {1, 1, 1});
  EXPECT_DOUBLE_EQ(BoxIou(unit, unit), 1);
  EXPECT_NEAR(BoxIou(unit, Box("a", {0.5, 0, 0}, {1, 1, 1})), 1.0 / 3, 1e-12);
  EXPECT_NEAR(BoxIou(unit, Box("a", {0, 0, 0.5}, {1, 1, 1})), 1.0 / 3, 1e-12);
  // A square and the same turned by 45 degrees share an octagon of 2 (sqrt 2 - 1).
  const double octagon = 2 * (std::numbers::sqrt2 - 1);
  EXPECT_NEAR(BoxIou(unit, Box("a", {0, 0, 0}, {1, 1, 1}, 45)), octagon / (2 - octagon), 1e-12);
  EXPECT_EQ(BoxIou(unit, Box("a", {3, 0, 0}, {1, 1, 1})), 0);
  EXPECT_EQ(BoxIou(unit, Box("a", {0, 0, 1}, {1, 1, 1})), 0);
  EXPECT_EQ(BoxIou(Box("a", {0, 0, 0}, {0, 0, 0}), Box("a", {0, 0, 0}, {0, 0, 0})), 0);
}

TEST(BoxIou, DoesNotDependOnOrderNorOnWhichSideIsCalledTheFront) {
  Random random(1);
  const auto draw = [&] {
    return Box("a",
               {random.Uniform(-0.4, 0.4), random.Uniform(-0.4, 0.4), random.Uniform(-0.4, 0.4)},
               {random.Uniform(0.3, 1.5), random.Uniform(0.3, 1.5), random.Uniform(0.3, 1.5)},
               random.Uniform(-180, 180));
  };
  for (int n = 0; n < 100; ++n) {
    const PlacedBox a = draw();
    const PlacedBox b = draw();
    PlacedBox turned = a;
    std::swap(turned.size_m.x(), turned.size_m.y());
    turned.world_from_object.rotation =
        a.world_from_object.rotation *
        Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()));
    EXPECT_NEAR(BoxIou(a, b), BoxIou(b, a), 1e-9);
    EXPECT_NEAR(BoxIou(a, b), BoxIou(turned, b), 1e-9);
    EXPECT_GE(BoxIou(a, b), 0);
    EXPECT_LE(BoxIou(a, b), 1);
  }
}

// A table, a chair at it that was taken for a cabinet, and a bed that nobody mapped; one box of
// ours stands where nothing is.
const std::vector<PlacedBox> kTruth = {Box("table", {0, 0, 0.4}, {1.4, 0.8, 0.8}),
                                       Box("chair", {2, 0, 0.45}, {0.5, 0.5, 0.9}),
                                       Box("bed", {5, 5, 0.3}, {2, 1, 0.6})};
const std::vector<PlacedBox> kMapped = {Box("cabinet", {2.05, 0, 0.45}, {0.5, 0.5, 0.9}),
                                        Box("table", {0.3, 0, 0.4}, {1.4, 0.8, 0.8}),
                                        Box("plant", {-4, 0, 0.4}, {0.4, 0.4, 0.8})};

TEST(BoxScore, CountsWhatIsFoundWhatIsRightAndWhatIsTakenForWhat) {
  const std::vector<PlacedBoxMatch> matches = MatchPlacedBoxes(kMapped, kTruth);
  ASSERT_EQ(matches.size(), 2U);
  const BoxScore loose = ScoreBoxes(kMapped, kTruth, matches, 0.25);
  EXPECT_NEAR(loose.recall(), 2.0 / 3, 1e-12);
  EXPECT_NEAR(loose.recall_right_class(), 1.0 / 3, 1e-12);
  EXPECT_NEAR(loose.precision(), 2.0 / 3, 1e-12);
  EXPECT_NEAR(loose.precision_right_class(), 1.0 / 3, 1e-12);
  EXPECT_EQ(ScoreBoxes(kMapped, kTruth, matches, 0.7).num_found, 1);
  EXPECT_THAT(CountConfusions(kMapped, kTruth, matches, 0.25),
              ElementsAre(Pair(Pair("chair", "cabinet"), 1)));
  BoxScore twice = loose;
  twice += loose;
  EXPECT_EQ(twice.num_true, 6);
  EXPECT_DOUBLE_EQ(twice.recall(), loose.recall());
}

TEST(BoxScore, OfTheTruthItselfEverythingIsRight) {
  const std::vector<PlacedBoxMatch> matches = MatchPlacedBoxes(kTruth, kTruth);
  const BoxScore score = ScoreBoxes(kTruth, kTruth, matches, 0.999);
  EXPECT_EQ(score.recall_right_class(), 1);
  EXPECT_EQ(score.precision_right_class(), 1);
  EXPECT_THAT(HoldersOfSeveral(kTruth, kTruth, matches, kMinIou), IsEmpty());
}

TEST(BoxScore, EachBoxIsMatchedOnceTheBestPairFirst) {
  const std::vector<PlacedBox> twice = {Box("chair", {2.2, 0, 0.45}, {0.5, 0.5, 0.9}),
                                        Box("chair", {2.01, 0, 0.45}, {0.5, 0.5, 0.9})};
  const std::vector<PlacedBoxMatch> matches = MatchPlacedBoxes(twice, kTruth);
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_EQ(matches[0].estimated, 1U);
  EXPECT_EQ(matches[0].truth, 1U);
}

TEST(BoxScore, WhatIsMergedAndWhatIsSplitIsTold) {
  const std::vector<PlacedBox> truth = {Box("chair", {0, 0, 0.45}, {0.5, 0.5, 0.9}),
                                        Box("chair", {0.6, 0, 0.45}, {0.5, 0.5, 0.9}),
                                        Box("sofa", {5, 0, 0.4}, {2, 0.9, 0.8})};
  const std::vector<PlacedBox> mapped = {Box("chair", {0.3, 0, 0.45}, {1.1, 0.5, 0.9}),
                                         Box("sofa", {4.5, 0, 0.4}, {1, 0.9, 0.8}),
                                         Box("sofa", {5.5, 0, 0.4}, {1, 0.9, 0.8})};
  const std::vector<PlacedBoxMatch> matches = MatchPlacedBoxes(mapped, truth);
  EXPECT_THAT(HoldersOfSeveral(mapped, truth, matches, kMinIou), ElementsAre(0U));
  EXPECT_THAT(HoldersOfSeveral(truth, mapped, Turned(matches), kMinIou), ElementsAre(2U));
}

TEST(BoxScore, ATableDoesNotMergeTheChairsUnderIt) {
  const std::vector<PlacedBox> both = {Box("table", {0, 0, 0.4}, {1.6, 1.2, 0.8}),
                                       Box("chair", {0.3, 0.3, 0.4}, {0.5, 0.5, 0.75}),
                                       Box("chair", {-0.3, 0.3, 0.4}, {0.5, 0.5, 0.75})};
  EXPECT_THAT(HoldersOfSeveral(both, both, MatchPlacedBoxes(both, both), kMinIou), IsEmpty());
  // It does where nothing else was mapped there.
  const std::vector<PlacedBox> table = {both[0]};
  EXPECT_THAT(HoldersOfSeveral(table, both, MatchPlacedBoxes(table, both), kMinIou),
              ElementsAre(0U));
}

TEST(BoxScore, OfNothingNothingIsMissed) {
  EXPECT_THAT(MatchPlacedBoxes({}, kTruth), IsEmpty());
  EXPECT_THAT(MatchPlacedBoxes(kMapped, {}), IsEmpty());
  EXPECT_EQ(ScoreBoxes({}, {}, {}, 0.25).recall(), 1);
  EXPECT_EQ(ScoreBoxes({}, kTruth, {}, 0.25).recall(), 0);
  EXPECT_EQ(ScoreBoxes({}, kTruth, {}, 0.25).precision(), 1);
}

}  // namespace
}  // namespace deepslam::eval
