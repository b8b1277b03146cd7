// Resume by content: what runs again, what does not, and what is said about it.
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <string_view>

#include <gmock/gmock.h>

#include "deepslam/pipeline/consistency.h"
#include "deepslam/pipeline/drop.h"
#include "deepslam/pipeline/runner.h"
#include "deepslam/pipeline/workspace.h"
#include "deepslam/storage/store.h"
#include "support/temp_dir.h"

namespace deepslam::pipeline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing_support::ReadText;
using testing_support::TempDir;
using testing_support::WriteText;
namespace fs = std::filesystem;

class RecordingListener final : public RunListener {
 public:
  void StageSkipped(std::string_view stage, std::string_view) override {
    skipped.emplace_back(stage);
  }
  void StageStarts(std::string_view stage, std::span<const std::string> why) override {
    ran.emplace_back(stage);
    reasons[std::string(stage)].assign(why.begin(), why.end());
  }
  void StageDone(std::string_view, std::string_view, const Timing&) override {}
  void Report(std::size_t, std::size_t) override {}
  void Warn(std::string_view) override {}
  [[nodiscard]] bool StopRequested() const override { return stop; }

  std::vector<std::string> ran;
  std::vector<std::string> skipped;
  std::map<std::string, std::vector<std::string>> reasons;
  bool stop = false;
};

// a -> b -> c, and d beside them. `a` writes its option, `b` only the option's first letter, `c`
// copies b.
struct Chain {
  std::string a_option = "north";
  std::string d_option = "1";
  std::string capture = "hash of the capture";
  int b_version = 1;
  std::function<Result<StageSummary>(StageContext&)> c_run;

  [[nodiscard]] std::vector<Stage> Stages() const {
    const auto a = [option = a_option](StageContext& context) -> Result<StageSummary> {
      if (Status s = context.Write("a.txt", option); !s.ok()) return s.error();
      return StageSummary{"wrote " + option, {{"length", static_cast<double>(option.size())}}};
    };
    const auto b = [](StageContext& context) -> Result<StageSummary> {
      const Result<std::string> text = context.Read("a", "a.txt");
      if (!text.ok()) return text.error();
      if (Status s = context.Write("deep/b.txt", text->substr(0, 1)); !s.ok()) return s.error();
      return StageSummary{"wrote", {}};
    };
    const auto c = [](StageContext& context) -> Result<StageSummary> {
      const Result<std::string> text = context.Read("b", "deep/b.txt");
      if (!text.ok()) return text.error();
      const auto write = [&](const TextSink& sink) {
        const Status s = sink(std::string_view(*text).substr(0, 1));
        return s.ok() ? sink(std::string_view(*text).substr(1)) : s;
      };
      if (Status s = context.Write("c.txt", write); !s.ok()) return s.error();
      return StageSummary{"copied", {}};
    };
    const auto d = [option = d_option](StageContext& context) -> Result<StageSummary> {
      if (Status s = context.Write("d.txt", option); !s.ok()) return s.error();
      return StageSummary{};
    };
    const auto external = [hash = capture]() -> Result<std::map<std::string, std::string>> {
      return std::map<std::string, std::string>{{"capture", hash}};
    };
    return {{"a", 1, {}, {{"a.option", a_option}}, external, a},
            {"b", b_version, {"a"}, {}, {}, b},
            {"c", 1, {"b"}, {}, {}, c_run ? c_run : c},
            {"d", 1, {}, {{"d.option", d_option}}, {}, d}};
  }
};

RecordingListener RunChain(const Chain& chain, const fs::path& workspace, RunRequest request = {}) {
  RecordingListener listener;
  request.workspace = workspace;
  const Result<RunReport> report = RunStages(chain.Stages(), request, listener);
  EXPECT_TRUE(report.ok()) << report.error().message;
  return listener;
}

std::map<std::string, std::string> FilesWithoutTimes(const fs::path& workspace) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(workspace)) {
    if (entry.is_regular_file() && entry.path().filename() != kTimingFile &&
        entry.path().filename() != ".lock") {
      files[fs::relative(entry.path(), workspace)] = ReadText(entry.path());
    }
  }
  return files;
}

TEST(Runner, RunsEverythingOnceAndNothingTwice) {
  const TempDir dir;
  EXPECT_THAT(RunChain({}, dir.path() / "w").ran, ElementsAre("a", "b", "c", "d"));
  const RecordingListener again = RunChain({}, dir.path() / "w");
  EXPECT_THAT(again.ran, IsEmpty());
  EXPECT_THAT(again.skipped, ElementsAre("a", "b", "c", "d"));
}

TEST(Runner, StagesOfTwoRunsAreToldApart) {
  const TempDir dir;
  RunChain({}, dir.path());
  EXPECT_TRUE(CheckConsistency(dir.path()).ok());
  RunRequest until_b;
  until_b.until = "b";
  Chain changed;
  changed.a_option = "south";
  RunChain(changed, dir.path(), until_b);
  const Status mixed = CheckConsistency(dir.path());
  ASSERT_FALSE(mixed.ok());
  EXPECT_THAT(mixed.error().message, HasSubstr("stage c was made from another b"));
  RunChain(changed, dir.path());
  EXPECT_TRUE(CheckConsistency(dir.path()).ok());
}

TEST(Runner, WhereNothingLiesNothingIsMixed) {
  const TempDir dir;
  EXPECT_TRUE(CheckConsistency(dir.path() / "missing").ok());
  WriteText(dir.path() / "a" / kManifestFile, "no manifest");
  EXPECT_TRUE(CheckConsistency(dir.path()).ok());
}

TEST(Runner, DroppedFilesAreGoneAndTheStagesStillStand) {
  const TempDir dir;
  RunRequest keep_c;
  keep_c.keep = {"c"};
  RunChain({}, dir.path(), keep_c);
  EXPECT_FALSE(fs::exists(dir.path() / "a" / "a.txt"));
  EXPECT_FALSE(fs::exists(dir.path() / "b" / "deep"));
  EXPECT_TRUE(fs::exists(dir.path() / "c" / "c.txt"));
  const RecordingListener again = RunChain({}, dir.path(), keep_c);
  EXPECT_THAT(again.ran, IsEmpty());
  EXPECT_THAT(again.skipped, ElementsAre("a", "b", "c", "d"));
  const auto states = InspectWorkspace(Chain{}.Stages(), dir.path());
  ASSERT_TRUE(states.ok()) << states.error().message;
  EXPECT_EQ(states->at(0).state, StageState::kDropped);
  EXPECT_EQ(states->at(2).state, StageState::kDone);
}

TEST(Runner, DroppedFilesComeBackWhereAStageNeedsThem) {
  const TempDir dir, whole;
  RunRequest keep_c;
  keep_c.keep = {"c"};
  RunChain({}, dir.path(), keep_c);
  RunChain({}, whole.path());
  RunRequest force_c;
  force_c.force = {"c"};
  RecordingListener listener = RunChain({}, dir.path(), force_c);
  EXPECT_THAT(listener.ran, ElementsAre("a", "b", "c")) << "c reads b, b reads a; nothing reads d";
  EXPECT_THAT(listener.reasons["b"], ElementsAre(HasSubstr("needed again")));
  EXPECT_TRUE(fs::exists(dir.path() / "b" / "deep" / "b.txt"));
  RunRequest force_d;
  force_d.force = {"d"};
  RunChain({}, dir.path(), force_d);
  EXPECT_EQ(FilesWithoutTimes(dir.path()), FilesWithoutTimes(whole.path()));
}

TEST(Runner, ChangedOptionRunsThroughDroppedStages) {
  const TempDir dir, whole;
  RunRequest keep_c;
  keep_c.keep = {"c"};
  RunChain({}, dir.path(), keep_c);
  Chain chain;
  chain.b_version = 2;  // b runs and gives what it gave: the cascade ends there
  EXPECT_THAT(RunChain(chain, dir.path()).ran, ElementsAre("a", "b"));
  chain.a_option = "south";
  chain.b_version = 3;
  RunChain(chain, dir.path(), keep_c);
  RunChain(chain, whole.path(), keep_c);
  EXPECT_EQ(FilesWithoutTimes(dir.path()), FilesWithoutTimes(whole.path()));
}

TEST(Runner, DropThatWasCutShortCountsAsDrop) {
  const TempDir dir;
  RunChain({}, dir.path());
  ASSERT_TRUE(DropOutputs(dir.path(), "b").ok());
  WriteText(dir.path() / "b" / "deep" / "b.txt", "half");
  RunRequest force_c;
  force_c.force = {"c"};
  RunChain({}, dir.path(), force_c);
  EXPECT_EQ(ReadText(dir.path() / "c" / "c.txt"), "n");
}

TEST(Runner, ChangedOptionRunsThatStageAndWhatDependsOnIt) {
  const TempDir dir;
  Chain chain;
  RunChain(chain, dir.path());
  chain.a_option = "south";
  RecordingListener listener = RunChain(chain, dir.path());
  EXPECT_THAT(listener.ran, ElementsAre("a", "b", "c"));
  EXPECT_THAT(listener.reasons["a"], ElementsAre("option a.option north -> south"));
  EXPECT_THAT(listener.reasons["b"], ElementsAre("input a changed"));
  chain.d_option = "2";
  EXPECT_THAT(RunChain(chain, dir.path()).ran, ElementsAre("d"));
}

TEST(Runner, EqualUpstreamOutputStopsTheCascade) {
  const TempDir dir;
  Chain chain;
  RunChain(chain, dir.path());
  chain.a_option = "nowhere";  // begins with the same letter: b's output stays the same
  EXPECT_THAT(RunChain(chain, dir.path()).ran, ElementsAre("a", "b"));
}

TEST(Runner, ChangedExternalInputAndVersionAreReasons) {
  const TempDir dir;
  Chain chain;
  RunChain(chain, dir.path());
  chain.capture = "another";
  RecordingListener listener = RunChain(chain, dir.path());
  EXPECT_THAT(listener.ran, ElementsAre("a"));
  EXPECT_THAT(listener.reasons["a"], ElementsAre("input capture changed"));
  chain.b_version = 2;
  listener = RunChain(chain, dir.path());
  EXPECT_THAT(listener.ran, ElementsAre("b"));
  EXPECT_THAT(listener.reasons["b"],
              ElementsAre("made by version 1 of the stage, this is version 2"));
}

TEST(Runner, DamagedAndMissingOutputsAreMadeAgain) {
  const TempDir dir;
  RunChain({}, dir.path());
  WriteText(dir.path() / "b" / "deep" / "b.txt", "x");
  RecordingListener listener = RunChain({}, dir.path());
  EXPECT_THAT(listener.ran, ElementsAre("b"));
  EXPECT_THAT(listener.reasons["b"], ElementsAre("output damaged: deep/b.txt"));
  fs::remove(dir.path() / "c" / "c.txt");
  EXPECT_THAT(RunChain({}, dir.path()).reasons["c"], ElementsAre("output missing: c.txt"));
  WriteText(dir.path() / "a" / "manifest.json", "{\"format\": \"deepslam/mani");
  listener = RunChain({}, dir.path());
  EXPECT_THAT(listener.ran, ElementsAre("a"));
  EXPECT_THAT(listener.reasons["a"][0], HasSubstr("manifest unusable"));
}

TEST(Runner, ForceAndUntil) {
  const TempDir dir;
  RunRequest until_b;
  until_b.until = "b";
  EXPECT_THAT(RunChain({}, dir.path(), until_b).ran, ElementsAre("a", "b"));
  RunRequest force_b;
  force_b.force = {"b"};
  RecordingListener listener = RunChain({}, dir.path(), force_b);
  EXPECT_THAT(listener.ran, ElementsAre("b", "c", "d"));
  EXPECT_THAT(listener.reasons["b"], ElementsAre("forced"));
  force_b.force = {"bee"};
  force_b.workspace = dir.path();
  RecordingListener silent;
  const Result<RunReport> report = RunStages(Chain().Stages(), force_b, silent);
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().code, ErrorCode::kInvalidConfig);
  EXPECT_THAT(report.error().message, testing::AllOf(HasSubstr("bee"), HasSubstr("a, b, c, d")));
}

TEST(Runner, ScratchFilesAreGoneWithTheirStage) {
  const TempDir dir;
  Chain chain;
  chain.c_run = [](StageContext& context) -> Result<StageSummary> {
    const std::string text = "aside";
    const auto scratch = context.Scratch();
    if (Status s = scratch->Append(std::as_bytes(std::span(text))); !s.ok()) return s.error();
    std::string back(text.size(), ' ');
    scratch->Read(0, std::as_writable_bytes(std::span(back)));
    if (Status s = context.Write("c.txt", back); !s.ok()) return s.error();
    return StageSummary{};
  };
  RunChain(chain, dir.path());
  EXPECT_EQ(ReadText(dir.path() / "c" / "c.txt"), "aside");
  EXPECT_EQ(std::distance(fs::directory_iterator(dir.path() / "c"), {}), 3)
      << "c.txt, manifest and timing";
}

TEST(Runner, WhatWasMadeOfAScratchFileThatFailedIsNobodysResult) {
  const TempDir dir;
  Chain chain;
  chain.c_run = [](StageContext& context) -> Result<StageSummary> {
    const auto scratch = context.Scratch();
    std::array<std::byte, 8> bytes;
    if (Status s = scratch->Append(bytes); !s.ok()) return s.error();
    scratch->Read(4, bytes);  // four more than are there
    if (Status s = context.Write("c.txt", "wrong"); !s.ok()) return s.error();
    return StageSummary{};
  };
  RecordingListener listener;
  const Result<RunReport> report = RunStages(chain.Stages(), {dir.path(), "", {}, {}}, listener);
  ASSERT_FALSE(report.ok());
  EXPECT_THAT(report.error().message, HasSubstr("cannot read a temporary file"));
  EXPECT_FALSE(fs::exists(dir.path() / "c"));
}

TEST(Runner, FailedStageLeavesTheOldOneAndNoPartial) {
  const TempDir dir;
  Chain chain;
  RunChain(chain, dir.path());
  chain.a_option = "south";
  chain.c_run = [](StageContext& context) -> Result<StageSummary> {
    if (Status s = context.Write("c.txt", "half"); !s.ok()) return s.error();
    return Failed("no luck");
  };
  RecordingListener listener;
  const Result<RunReport> report = RunStages(chain.Stages(), {dir.path(), "", {}, {}}, listener);
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().message, "c: no luck");
  EXPECT_EQ(ReadText(dir.path() / "c" / "c.txt"), "n");
  for (const auto& entry : fs::directory_iterator(dir.path())) {
    EXPECT_THAT(entry.path().filename().string(), testing::Not(HasSubstr("partial")));
  }
}

TEST(Runner, KilledRunGoesOnWithEqualBytes) {
  const TempDir undisturbed;
  RunChain({}, undisturbed.path());
  const TempDir dir;
  RunRequest until;
  until.until = "b";
  RunChain({}, dir.path(), until);
  // What a killed process (4194305 is beyond all numbers) leaves: a half-written stage, and one
  // that was moved aside while being replaced.
  WriteText(dir.path() / "c.partial-99999" / "c.txt", "ha");
  WriteText(dir.path() / "workspace.json.tmp-4194305", "{");
  WriteText(dir.path() / "timing.html.tmp-4194305", "<");
  WriteText(dir.path() / "a" / "dropped.json.tmp-4194305", "{");
  WriteText(dir.path() / "notes.txt.tmp-1", "the user's own");
  fs::rename(dir.path() / "b", dir.path() / "b.old-99999");
  WriteText(dir.path() / "mine.partial-1" / "notes.txt", "the user's own");
  EXPECT_THAT(RunChain({}, dir.path()).ran, ElementsAre("b", "c", "d"));
  EXPECT_FALSE(fs::exists(dir.path() / "c.partial-99999"));
  EXPECT_FALSE(fs::exists(dir.path() / "workspace.json.tmp-4194305"));
  EXPECT_FALSE(fs::exists(dir.path() / "timing.html.tmp-4194305"));
  EXPECT_FALSE(fs::exists(dir.path() / "a" / "dropped.json.tmp-4194305"));
  EXPECT_TRUE(fs::remove(dir.path() / "notes.txt.tmp-1"));
  EXPECT_FALSE(fs::exists(dir.path() / "b.old-99999"));
  EXPECT_TRUE(fs::exists(dir.path() / "mine.partial-1"));
  fs::remove_all(dir.path() / "mine.partial-1");
  EXPECT_EQ(FilesWithoutTimes(dir.path()), FilesWithoutTimes(undisturbed.path()));
}

TEST(Runner, InterruptedRunIsResumable) {
  const TempDir dir;
  RecordingListener listener;
  Chain chain;
  chain.c_run = [&](StageContext&) -> Result<StageSummary> { return Interrupted(); };
  const Result<RunReport> report = RunStages(chain.Stages(), {dir.path(), "", {}, {}}, listener);
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().code, ErrorCode::kInterrupted);
  EXPECT_THAT(RunChain({}, dir.path()).ran, ElementsAre("c", "d"));
}

TEST(Runner, MissingExternalInputIsToldBeforeAnythingRuns) {
  const TempDir dir;
  std::vector<Stage> stages = Chain().Stages();
  stages[3].external_inputs = []() -> Result<std::map<std::string, std::string>> {
    return InvalidInput("no weights");
  };
  RecordingListener listener;
  const Result<RunReport> report = RunStages(stages, {dir.path(), "", {}, {}}, listener);
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().code, ErrorCode::kInvalidInput);
  EXPECT_EQ(report.error().message, "d: no weights");
  EXPECT_THAT(listener.ran, IsEmpty());
}

TEST(Workspace, IsHeldByOneRunAtATime) {
  const TempDir dir;
  const std::vector<std::string> names = {"a"};
  Result<Workspace> first = Workspace::Open(dir.path(), names);
  ASSERT_TRUE(first.ok());
  const Result<Workspace> second = Workspace::Open(dir.path(), names);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::kFailed);
  EXPECT_THAT(second.error().message, HasSubstr(std::to_string(::getpid())));
  { const Workspace released = std::move(first).value(); }
  EXPECT_TRUE(Workspace::Open(dir.path(), names).ok());
}

TEST(Workspace, RefusesForeignFoldersAndOtherVersions) {
  const TempDir dir;
  const std::vector<std::string> names = {"a"};
  WriteText(dir.path() / "photos" / "cat.jpg", "miau");
  Result<Workspace> workspace = Workspace::Open(dir.path() / "photos", names);
  ASSERT_FALSE(workspace.ok());
  EXPECT_THAT(workspace.error().message, HasSubstr("choose an empty or new folder"));
  ASSERT_TRUE(Workspace::Open(dir.path() / "w", names).ok());
  WriteText(dir.path() / "w" / "workspace.json",
            R"({"format": "deepslam/workspace", "version": 7})");
  workspace = Workspace::Open(dir.path() / "w", names);
  ASSERT_FALSE(workspace.ok());
  EXPECT_THAT(workspace.error().message,
              testing::AllOf(HasSubstr("use a newer deepslam"), HasSubstr("choose another")));
}

TEST(Workspace, SaysWhyItCannotBeMade) {
  const std::vector<std::string> names = {"a"};
  const Result<Workspace> workspace = Workspace::Open("/proc/deepslam", names);
  ASSERT_FALSE(workspace.ok());
  EXPECT_EQ(workspace.error().code, ErrorCode::kFailed);
  EXPECT_THAT(workspace.error().message, HasSubstr("/proc/deepslam"));
}

TEST(Inspect, TellsDoneStaleAndMissing) {
  const TempDir dir;
  RunRequest until;
  until.until = "c";
  RunChain({}, dir.path(), until);
  Chain changed;
  changed.b_version = 2;
  const Result<std::vector<StageReport>> reports = InspectWorkspace(changed.Stages(), dir.path());
  ASSERT_TRUE(reports.ok());
  EXPECT_EQ((*reports)[0].state, StageState::kDone);
  EXPECT_EQ((*reports)[0].num_bytes, 5U);
  EXPECT_EQ((*reports)[1].state, StageState::kStale);
  EXPECT_EQ((*reports)[2].state, StageState::kStale);
  EXPECT_THAT((*reports)[2].reasons, ElementsAre("input b is to be made first"));
  EXPECT_EQ((*reports)[3].state, StageState::kMissing);
  EXPECT_FALSE(InspectWorkspace(changed.Stages(), dir.path() / "none").ok());
}

TEST(Inspect, LooksAtWhatItIsTold) {
  const TempDir dir;
  RunChain({}, dir.path());
  Chain elsewhere;
  elsewhere.capture = "hash of another capture";
  const auto recorded = InspectWorkspace(elsewhere.Stages(), dir.path());
  ASSERT_TRUE(recorded.ok());
  EXPECT_EQ((*recorded)[0].state, StageState::kDone);
  constexpr std::array<std::string_view, 2> kLookedAt = {"capture", "overrides"};
  const auto now = InspectWorkspace(elsewhere.Stages(), dir.path(), kLookedAt);
  ASSERT_TRUE(now.ok());
  EXPECT_EQ((*now)[0].state, StageState::kStale);
  EXPECT_EQ((*now)[3].state, StageState::kDone);
}

}  // namespace
}  // namespace deepslam::pipeline
