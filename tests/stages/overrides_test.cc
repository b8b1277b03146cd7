// A person's corrections: what runs again because of them, and what cannot be chosen.
#include <set>

#include <gmock/gmock.h>

#include "deepslam/artifact/overrides_yaml.h"
#include "deepslam/modelling/candidate_set.h"
#include "deepslam/stages/object_sources.h"
#include "deepslam/stages/plan.h"

namespace deepslam::stages {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Overrides Parsed(const std::string& text) {
  const Result<Overrides> overrides = artifact::DecodeOverrides(text, "overrides.yaml");
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

TEST(SelectOrChoose, SaysWhyWhatWasChosenFitsNowhere) {
  modelling::CandidateSet set = {ObjectId{1}, "chair", {}, {}, {}, {}, {}};
  set.candidates.resize(1);
  set.candidates[0].id = CandidateId{8};
  set.registrations.resize(1);
  set.scores.resize(1);
  set.scores[0].candidate = CandidateId{8};
  const Overrides overrides = Parsed("choose: {1: 8}");
  const modelling::ObjectOptions options = ObjectOptionsOf({}, overrides);
  std::vector<std::string> applied;
  const auto why = [&](bool ok, const std::string& note) {
    set.registrations[0].ok = ok;
    set.scores[0].note = note;
    const Result<MapObject> chosen = modelling::SelectOrChoose(set, {}, options, applied);
    return chosen.ok() ? "" : chosen.error().message;
  };
  EXPECT_EQ(
      why(false, "no view has enough points"),
      "overrides.yaml: choose: candidate 8 of object 1 fits nowhere: no view has enough points; "
      "choose another one, or none");
  EXPECT_THAT(why(true, ""), HasSubstr("fits nowhere: it agrees with none of the depth; choose"));
  EXPECT_THAT(applied, IsEmpty());
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
  EXPECT_THAT(StagesTouched("choose: {chair_01: 5}"), ElementsAre("loops", "select"));
}

}  // namespace
}  // namespace deepslam::stages
