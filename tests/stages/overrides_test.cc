// A person's corrections: what they change, and what runs again because of them.
#include "deepslam/stages/apply_overrides.h"

#include <gmock/gmock.h>

#include "deepslam/stages/judge_object.h"
#include "deepslam/stages/plan.h"

namespace deepslam::stages {
namespace {

using artifact::DecodeOverrides;
using artifact::Overrides;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Overrides Parsed(const std::string& text) {
  const Result<Overrides> overrides = DecodeOverrides(text, "overrides.yaml");
  EXPECT_TRUE(overrides.ok()) << overrides.error().message;
  return *overrides;
}

ClassTable Classes() {
  ClassTable table;
  for (const char* name : {"chair", "table"}) {
    table.classes.emplace_back();
    table.classes.back().name = name;
  }
  return table;
}

// Chair 0 in frames 0 10 20, chair 3 in 30 40, table 5 in 0 40.
Association ThreeObjects() {
  Association association;
  int detection = 0;
  const auto add = [&](int id, const char* class_name, const std::vector<int>& frames) {
    ObjectTrack track{ObjectId{id}, class_name, {}, "new"};
    for (const int frame : frames) {
      track.members.push_back({DetectionId{detection++}, FrameIdx{frame}, 0, 0, "vote"});
    }
    association.tracks.push_back(track);
  };
  add(0, "chair", {0, 10, 20});
  add(3, "chair", {30, 40});
  add(5, "table", {0, 40});
  return association;
}

std::vector<int> Frames(const ObjectTrack& track) {
  std::vector<int> frames;
  for (const TrackMember& member : track.members) frames.push_back(member.frame.value);
  return frames;
}

TEST(ApplyToTracks, MergesSplitsRelabelsAndDrops) {
  Association merged = ThreeObjects();
  ASSERT_TRUE(ApplyToTracks(Parsed("merge: [[0, chair_03]]"), Classes(), merged).ok());
  ASSERT_EQ(merged.tracks.size(), 2U);
  EXPECT_EQ(merged.tracks[0].id.value, 0);
  EXPECT_THAT(Frames(merged.tracks[0]), ElementsAre(0, 10, 20, 30, 40));

  Association split = ThreeObjects();
  ASSERT_TRUE(
      ApplyToTracks(Parsed("split: [{object: 0, at_frames: [10, 15]}]"), Classes(), split).ok());
  ASSERT_EQ(split.tracks.size(), 5U);
  EXPECT_THAT(Frames(split.tracks[0]), ElementsAre(0));
  EXPECT_EQ(split.tracks[3].id.value, 6);
  EXPECT_THAT(Frames(split.tracks[3]), ElementsAre(10));
  EXPECT_EQ(split.tracks[4].id.value, 7);
  EXPECT_THAT(Frames(split.tracks[4]), ElementsAre(20));
  EXPECT_EQ(split.tracks[4].class_name, "chair");

  Association relabelled = ThreeObjects();
  ASSERT_TRUE(ApplyToTracks(Parsed("relabel: {3: table}"), Classes(), relabelled).ok());
  EXPECT_EQ(relabelled.tracks[1].class_name, "table");

  Association dropped = ThreeObjects();
  const auto applied = ApplyToTracks(Parsed("drop: [5]"), Classes(), dropped);
  ASSERT_TRUE(applied.ok());
  EXPECT_THAT(*applied, ElementsAre(HasSubstr("object 5")));
  EXPECT_EQ(dropped.tracks.size(), 2U);
  ASSERT_EQ(dropped.rejections.size(), 2U);  // its detections are accounted for
  EXPECT_THAT(dropped.rejections[0].reason, HasSubstr("hand"));
}

TEST(ApplyToTracks, DoesNothingWithoutOverrides) {
  Association association = ThreeObjects();
  const auto applied = ApplyToTracks({}, Classes(), association);
  ASSERT_TRUE(applied.ok());
  EXPECT_THAT(*applied, IsEmpty());
  EXPECT_EQ(association.tracks.size(), 3U);
}

TEST(ApplyToTracks, NamesTheLineAndWhatIsKnown) {
  const auto fault = [](const std::string& text) {
    Association association = ThreeObjects();
    const auto applied = ApplyToTracks(Parsed(text), Classes(), association);
    EXPECT_FALSE(applied.ok()) << text;
    if (applied.ok()) return std::string();
    EXPECT_EQ(applied.error().code, ErrorCode::kInvalidConfig);
    return applied.error().message;
  };
  EXPECT_THAT(fault("# first\ndrop:\n  - 0\n  - 9\n"),
              testing::AllOf(HasSubstr("overrides.yaml:4"),
                             HasSubstr("no object 9"),
                             HasSubstr("0 (chair), 3 (chair), 5 (table)")));
  EXPECT_THAT(fault("relabel: {3: sofa}"), HasSubstr("known are chair, table"));
  EXPECT_THAT(fault("merge: [[0, 8]]"), HasSubstr("no object 8"));
  EXPECT_THAT(fault("split: [{object: 0, at_frames: [21]}]"), HasSubstr("0, 10, 20"));
  EXPECT_THAT(fault("split: [{object: 0, at_frames: [0]}]"), HasSubstr("one side"));
  EXPECT_THAT(fault("merge: [[0, 3]]\ndrop: [3]"), HasSubstr("dropped as well"));
}

TEST(ApplyToTracks, RefusesNamesOfOtherObjects) {
  const auto applied = [](const std::string& text) {
    Association association = ThreeObjects();
    return ApplyToTracks(Parsed(text), Classes(), association);
  };
  for (const char* text : {"drop:\n  - table_03",
                           "merge:\n  - [0, table_03]",
                           "merge:\n  - [table_03, 0]",
                           "split:\n  - {object: table_03, at_frames: [40]}",
                           "relabel:\n  table_03: chair",
                           "relabel: {3: lamp}\ndrop: [table_03]"}) {
    const auto result = applied(text);
    ASSERT_FALSE(result.ok()) << text;
    EXPECT_EQ(result.error().code, ErrorCode::kInvalidConfig);
    EXPECT_THAT(result.error().message,
                testing::AllOf(HasSubstr("overrides.yaml:2: there is no object table_03"),
                               HasSubstr("object 3 is called chair_03 (write 3"),
                               HasSubstr("known are 0 (chair), 3 (chair), 5 (table)")));
  }
  // Under its own name, as it was found or as the file relabels it, whatever the digits.
  for (const char* text : {"drop: [chair_03, chair_0, table_005]",
                           "relabel: {5: chair}\nmerge: [[0, table_05]]",
                           "relabel: {table_05: chair}\ndrop: [chair_05]"}) {
    EXPECT_TRUE(applied(text).ok()) << text;
  }
  EXPECT_THAT(applied("drop: [table_09]").error().message, HasSubstr("no object 9"));
  EXPECT_FALSE(DecodeOverrides("drop: [_03]", "o.yaml").ok());
}

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

TEST(DecodeOverrides, FindsEveryFaultWithItsLine) {
  const auto overrides = DecodeOverrides(
      "version: 2\n"
      "dorp: [1]\n"
      "drop: [-1, 1, 1]\n"
      "merge: [[1]]\n"
      "split: [{object: 2, frames: [3]}]\n"
      "choose: [1]\n"
      "ground: {height_m: -1}\n",
      "o.yaml");
  ASSERT_FALSE(overrides.ok());
  EXPECT_EQ(overrides.error().code, ErrorCode::kInvalidConfig);
  for (const char* part : {"o.yaml:1: version",
                           "o.yaml:2: unknown key \"dorp\"; known are version, drop",
                           "o.yaml:3: \"-1\" is no object",
                           "o.yaml:3: object 1 stands twice",
                           "o.yaml:4: must be a list of two",
                           "o.yaml:5: unknown key \"frames\"; known are object, at_frames",
                           "o.yaml:6: must be a map",
                           "o.yaml:7: height_m"}) {
    EXPECT_THAT(overrides.error().message, HasSubstr(part));
  }
  EXPECT_FALSE(DecodeOverrides("drop: [", "o.yaml").ok());
  EXPECT_FALSE(DecodeOverrides("- 1", "o.yaml").ok());
  EXPECT_TRUE(DecodeOverrides("# nothing yet\n", "o.yaml").ok());
  EXPECT_TRUE(DecodeOverrides("", "o.yaml").ok());
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

TEST(SelectOrChoose, SaysWhyWhatWasChosenFitsNowhere) {
  Contest contest = {ObjectId{1}, "chair", {}, {}, {}, {}, {}};
  contest.candidates.resize(1);
  contest.candidates[0].id = CandidateId{8};
  contest.registrations.resize(1);
  contest.scores.resize(1);
  contest.scores[0].candidate = CandidateId{8};
  RunInputs inputs;
  inputs.overrides = Parsed("choose: {1: 8}");
  std::vector<std::string> applied;
  const auto why = [&](bool ok, const std::string& note) {
    contest.registrations[0].ok = ok;
    contest.scores[0].note = note;
    const Result<MapObject> chosen = SelectOrChoose(contest, {}, inputs, applied);
    return chosen.ok() ? "" : chosen.error().message;
  };
  EXPECT_EQ(
      why(false, "no view has enough points"),
      "overrides.yaml: choose: candidate 8 of object 1 fits nowhere: no view has enough points; "
      "choose another one, or none");
  EXPECT_THAT(why(true, ""), HasSubstr("fits nowhere: it agrees with none of the depth; choose"));
  EXPECT_THAT(applied, IsEmpty());
}

TEST(ApplyToGround, LeavesPartsAloneThatWereNotMeasuredAgainstTheFirstCamera) {
  const Overrides hint = Parsed("ground: {up_camera: [0, -1, 0], height_m: 1.4}\n");
  Odometry odometry;
  odometry.frames.resize(2);
  const Plane low{-Eigen::Vector3d::UnitY(), 0.7};
  Ground ground;
  ground.plane_world = low;
  ground.observations = {{FrameIdx{0}, low, Eigen::Matrix3d::Identity(), 1},
                         {FrameIdx{1}, low, Eigen::Matrix3d::Identity(), 1}};
  ground.apart = {{FrameIdx{1}, FrameIdx{2}, low}};
  EXPECT_THAT(ApplyToGround(hint, odometry, ground), ElementsAre(HasSubstr("1 of 2")));
  EXPECT_DOUBLE_EQ(ground.plane_world->d_m, 1.4);
  ASSERT_EQ(ground.observations.size(), 1U);
  EXPECT_EQ(ground.observations[0].keyframe, FrameIdx{1});
  EXPECT_DOUBLE_EQ(ground.apart[0].plane_world->d_m, 0.7);
}

TEST(ApplyToGround, HintStandsInForGroundThatDisagrees) {
  Odometry odometry;
  odometry.frames.resize(2);
  odometry.frames[1].world_from_camera.translation_m = {0, -0.2, 0};  // 0.2 m higher
  const Plane floor{{0, -1, 0}, 1.4};
  const Plane table{{0, -1, 0}, 0.7};
  Ground found;
  found.plane_world = table;
  found.observations = {{FrameIdx{0}, table}, {FrameIdx{1}, {{0, -1, 0}, 1.6}}};
  const Overrides hint = Parsed("ground: {up_camera: [0, -2, 0], height_m: 1.38}");
  EXPECT_EQ(ApplyToGround(hint, odometry, found).size(), 1U);
  ASSERT_EQ(found.observations.size(), 1U);
  EXPECT_EQ(found.observations[0].keyframe.value, 1);
  EXPECT_NEAR(found.plane_world->d_m, 1.38, 1e-12);
  // One that agrees stays as it was measured.
  Ground good;
  good.plane_world = floor;
  EXPECT_EQ(ApplyToGround(hint, odometry, good).size(), 1U);
  EXPECT_EQ(*good.plane_world, floor);
}

// Stages whose inputs from outside differ from those of a run without overrides.
std::set<std::string> StagesTouched(const std::string& text) {
  Config config;
  config.detect_stage.source = "none";
  config.propose_stage.retrieval = false;
  const auto plan = [&](const Overrides& overrides) {
    return MakePlan(
        std::make_shared<const RunInputs>(RunInputs{config, Classes(), nullptr, {}, overrides}));
  };
  const std::vector<pipeline::Stage> without = plan({});
  const std::vector<pipeline::Stage> with = plan(Parsed(text));
  std::set<std::string> names;
  for (std::size_t n = 0; n < with.size(); ++n) {
    if (*without[n].external_inputs() != *with[n].external_inputs()) names.insert(with[n].name);
  }
  return names;
}

TEST(Overrides, ReachOnlyTheStagesTheyConcern) {
  EXPECT_THAT(StagesTouched("# nothing\n"), IsEmpty());
  EXPECT_THAT(StagesTouched("drop: [1]"), ElementsAre("associate"));
  EXPECT_THAT(StagesTouched("merge: [[1, 2]]"), ElementsAre("associate"));
  EXPECT_THAT(StagesTouched("relabel: {1: chair}"), ElementsAre("associate"));
  EXPECT_THAT(StagesTouched("choose: {1: 5}"), ElementsAre("loops", "select"));
  EXPECT_THAT(StagesTouched("ground: {height_m: 1.5}"), ElementsAre("ground"));
}

TEST(Overrides, CommentsAndOrderOfKeysChangeNothing) {
  const Overrides a = Parsed("drop: [4, 1]\nrelabel: {2: chair, 3: table}\n");
  const Overrides b = Parsed("# why\nrelabel:\n  table_03: table\n  2: chair\ndrop: [1, 4]\n");
  EXPECT_EQ(artifact::TrackOverridesText(a), artifact::TrackOverridesText(b));
  EXPECT_NE(artifact::TrackOverridesText(a), artifact::TrackOverridesText(Parsed("drop: [4]")));
}

// Else a stage that stands would hide that the name is wrong.
TEST(Overrides, NamesThatHaveToBeCheckedRunTheirStage) {
  using artifact::TrackOverridesText;
  EXPECT_NE(TrackOverridesText(Parsed("drop: [4]")), TrackOverridesText(Parsed("drop: [sofa_04]")));
  EXPECT_EQ(TrackOverridesText(Parsed("drop: [chair_4, chair_01]")),
            TrackOverridesText(Parsed("drop: [chair_01, chair_04]")));
  EXPECT_NE(artifact::ChoiceOverridesText(Parsed("choose: {1: 8}")),
            artifact::ChoiceOverridesText(Parsed("choose: {chair_01: 8}")));
  EXPECT_THAT(StagesTouched("choose: {chair_01: 5}"), ElementsAre("loops", "select"));
  EXPECT_NE(TrackOverridesText(Parsed("relabel: {1: table}")),
            TrackOverridesText(Parsed("relabel: {1: table}\nchoose: {chair_01: 5}")));
}

}  // namespace
}  // namespace deepslam::stages
