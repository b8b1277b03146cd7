#include "deepslam/overrides/choices.h"

#include <gmock/gmock.h>

#include "deepslam/overrides/apply_to_tracks.h"
#include "overrides/sample_objects.h"

namespace deepslam::overrides {
namespace {

using testing::HasSubstr;

TEST(CheckChoices, RefusesNamesOfOtherObjects) {
  // What both stages say, one after the other.
  const auto check = [](const std::string& text) -> Status {
    const Overrides overrides = Parsed(text);
    Association association = ThreeObjects();
    const auto applied = ApplyToTracks(overrides, Classes(), association);
    return applied.ok() ? CheckChoices(overrides, association.tracks) : applied.error();
  };
  const Status wrong = check("choose:\n  table_03: 8");
  ASSERT_FALSE(wrong.ok());
  EXPECT_THAT(wrong.error().message,
              testing::AllOf(HasSubstr("overrides.yaml:2: there is no object table_03"),
                             HasSubstr("called chair_03")));
  EXPECT_TRUE(check("choose: {chair_03: 8, 5: 7}").ok());
  // A relabelled object has two names.
  EXPECT_TRUE(check("relabel: {3: table}\nchoose: {table_03: 8}").ok());
  EXPECT_TRUE(check("relabel: {3: table}\nchoose: {chair_03: 8}").ok());
  EXPECT_FALSE(check("relabel: {3: table}\nchoose: {lamp_03: 8}").ok());
  // So has a part of a split object.
  EXPECT_TRUE(check("split: [{object: 0, at_frames: [10]}]\nchoose: {chair_06: 8}").ok());
  EXPECT_FALSE(check("split: [{object: 0, at_frames: [10]}]\nchoose: {table_06: 8}").ok());
}

TEST(ChosenByHand, TakesNumbersAndModelsAndNamesTheKnown) {
  std::vector<ShapeCandidate> candidates(2);
  candidates[0].id = CandidateId{7};
  candidates[0].model = "maker__chair";
  candidates[1].id = CandidateId{8};
  candidates[1].model = "maker__stool";
  const auto chosen = [&](const std::string& text, int object) {
    return ChosenByHand(Parsed(text), ObjectId{object}, candidates);
  };
  EXPECT_EQ(chosen("choose: {1: 8}", 1)->value, 8);
  EXPECT_EQ(chosen("choose: {1: maker__chair}", 1)->value, 7);
  EXPECT_FALSE(chosen("choose: {1: 8}", 2)->valid());
  const auto unknown = chosen("choose:\n  1: throne", 1);
  ASSERT_FALSE(unknown.ok());
  EXPECT_THAT(unknown.error().message, HasSubstr("overrides.yaml:2"));
  EXPECT_THAT(unknown.error().message, HasSubstr("7 (maker__chair), 8 (maker__stool)"));
  EXPECT_THAT(CheckChoices(Parsed("choose: {1: 8}"), ThreeObjects().tracks).error().message,
              HasSubstr("no object 1 to choose a candidate for; known are 0 (chair), 3"));
}

}  // namespace
}  // namespace deepslam::overrides
