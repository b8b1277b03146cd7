// Files of a batch: what is written reads back, what is damaged or from elsewhere is refused.
#include <gmock/gmock.h>

#include "deepslam/batch/batch_plan.h"
#include "deepslam/batch/batch_state.h"
#include "deepslam/batch/capture_record.h"
#include "deepslam/batch/slurm.h"

namespace deepslam::batch {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

CaptureRecord FullRecord() {
  CaptureRecord record;
  record.name = "kitchen";
  record.capture = "/data/kitchen";
  record.state = CaptureState::kDone;
  record.attempts = 2;
  record.host = "node7";
  record.started_s = 1'700'000'000;
  record.ended_s = 1'700'000'060;
  record.wall_s = 71.25;
  record.attempt_s = 60.5;
  record.stage_s = {{"track", 12.5}, {"mesh", 3}};
  record.verdict = "doubtful";
  record.verdict_reasons = {"12 % of the frames could not be tracked"};
  record.objects = {{"chair", 3}, {"table", 1}};
  record.num_frames = 120;
  record.path_error = PathError{0.0125, 118, 120};
  record.num_bytes = 12'345'678;
  return record;
}

TEST(BatchFiles, RecordReadsBack) {
  const auto text = EncodeRecord(FullRecord(), "r");
  ASSERT_TRUE(text.ok()) << text.error().message;
  const auto record = DecodeRecord(*text, "r");
  ASSERT_TRUE(record.ok()) << record.error().message;
  EXPECT_EQ(*EncodeRecord(*record, "r"), *text);
  EXPECT_EQ(NumObjects(*record), 4);
  EXPECT_EQ(record->path_error->num_scored, 118);
  EXPECT_EQ(record->stage_s.at("track"), 12.5);
}

TEST(BatchFiles, ReasonsThatAreNoUtf8AreStillWritten) {
  CaptureRecord record = FullRecord();
  record.state = CaptureState::kFailed;
  record.reason = "\xFF\xFE.png: cannot be read";
  const auto text = EncodeRecord(record, "r");
  ASSERT_TRUE(text.ok()) << text.error().message;
  EXPECT_EQ(DecodeRecord(*text, "r")->reason, "??.png: cannot be read");
}

TEST(BatchFiles, EveryCutRecordIsRefused) {
  const std::string text = *EncodeRecord(FullRecord(), "r");
  for (std::size_t size = 0; size + 2 < text.size(); size += 7)
    EXPECT_FALSE(DecodeRecord(text.substr(0, size), "r").ok()) << size;
}

TEST(BatchFiles, ForeignAndFutureFilesAreRefused) {
  const std::string text = *EncodeRecord(FullRecord(), "r");
  std::string future = text;
  future.replace(future.find("\"version\": 1"), 12, "\"version\": 9");
  EXPECT_THAT(DecodeRecord(future, "r").error().message, HasSubstr("newer"));
  EXPECT_FALSE(DecodePlan(text, "r").ok());
  EXPECT_FALSE(DecodeBatch(text, "r").ok());
  std::string state = text;
  state.replace(state.find("\"done\""), 6, "\"gone\"");
  EXPECT_THAT(DecodeRecord(state, "r").error().message, HasSubstr("state"));
}

TEST(BatchFiles, PlanReadsBack) {
  const BatchPlan plan{{{"/data/a b", "a_b"}, {"/data/c", "c"}}, "{}", "track", true, 3, "/share"};
  const auto text = EncodePlan(plan, "p");
  ASSERT_TRUE(text.ok());
  const auto read = DecodePlan(*text, "p");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(*read, plan);
}

BatchState States(const std::vector<CaptureState>& states) {
  BatchState batch;
  batch.state = "running";
  batch.engine = "local";
  for (const CaptureState state : states) {
    batch.captures.push_back(FullRecord());
    batch.captures.back().state = state;
  }
  return batch;
}

TEST(BatchFiles, BatchReadsBackAndCounts) {
  const BatchState batch = States({CaptureState::kDone,
                                   CaptureState::kFailed,
                                   CaptureState::kWaiting,
                                   CaptureState::kDone,
                                   CaptureState::kRunning});
  const auto text = EncodeBatch(batch, "b");
  ASSERT_TRUE(text.ok()) << text.error().message;
  const auto read = DecodeBatch(*text, "b");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(*EncodeBatch(*read, "b"), *text);
  const StateCounts counts = Count(*read);
  EXPECT_EQ(counts.done, 2);
  EXPECT_EQ(counts.failed, 1);
  EXPECT_EQ(counts.waiting + counts.running, 2);
}

TEST(BatchFiles, ExitCodes) {
  EXPECT_EQ(ExitCode(States({CaptureState::kDone, CaptureState::kDone})), 0);
  EXPECT_EQ(ExitCode(States({CaptureState::kDone, CaptureState::kFailed})), 1);
  EXPECT_EQ(ExitCode(States({CaptureState::kFailed, CaptureState::kWaiting})), 130);
  EXPECT_EQ(ExitCode(States({CaptureState::kDone, CaptureState::kInterrupted})), 130);
}

TEST(BatchFiles, TimesAreUtc) {
  EXPECT_EQ(UtcText(0), "");
  EXPECT_EQ(UtcText(1'700'000'000), "2023-11-14T22:13:20Z");
}

SlurmBatch FortyCaptures() {
  SlurmBatch batch;
  batch.root = "/share/my batch";
  batch.program = "/opt/deepslam";
  batch.script = "/share/my batch/.batch/task.sh";
  batch.num_captures = 40;
  batch.num_threads = 4;
  return batch;
}

TEST(Slurm, ArrayCoversEveryCapture) {
  SlurmBatch batch = FortyCaptures();
  EXPECT_THAT(SubmitArray(batch), Contains("--array=0-39"));
  batch.at_a_time = 8;
  batch.per_task = 3;
  EXPECT_THAT(SubmitArray(batch), Contains("--array=0-13%8"));
  EXPECT_THAT(SubmitArray(batch), Contains("--requeue"));
  EXPECT_THAT(SubmitArray(batch), Contains("--cpus-per-task=4"));
}

TEST(Slurm, OptionsReachBothJobsAndComeBeforeTheScript) {
  SlurmBatch batch = FortyCaptures();
  batch.options = {"gpu", "01:00:00", "4G", {"--account=lab"}};
  const std::vector<std::string> array = SubmitArray(batch);
  for (const char* option : {"--partition=gpu", "--time=01:00:00", "--mem=4G", "--account=lab"}) {
    const auto at = std::find(array.begin(), array.end(), option);
    ASSERT_NE(at, array.end()) << option;
    EXPECT_LT(at, std::find(array.begin(), array.end(), batch.script.string()));
  }
  const std::vector<std::string> summary = SubmitSummary(batch, "123");
  EXPECT_THAT(summary, Contains("--dependency=afterany:123"));
  EXPECT_THAT(summary, Contains("--partition=gpu"));
  EXPECT_THAT(summary, Not(Contains("--mem=4G")));
}

TEST(Slurm, ArraysStayBelowTheClustersLimit) {
  EXPECT_EQ(CapturesPerTask(40, 1000), 1);
  EXPECT_EQ(CapturesPerTask(1000, 1000), 1);
  EXPECT_EQ(CapturesPerTask(1001, 1000), 2);
  EXPECT_EQ(CapturesPerTask(100'000, 1000), 100);
}

TEST(Slurm, AnswersAreRead) {
  EXPECT_EQ(*ParseJobId("123\n"), "123");
  EXPECT_EQ(*ParseJobId("77;cluster2\n"), "77");
  EXPECT_FALSE(ParseJobId("").ok());
  EXPECT_FALSE(ParseJobId("Submitted batch job 5").ok());
  const std::vector<std::string> ids = {"12", "13"};
  EXPECT_TRUE(AnyInQueue("5\n13  \n", ids));
  EXPECT_FALSE(AnyInQueue("5\n123\n", ids));
  EXPECT_FALSE(AnyInQueue("", ids));
  EXPECT_EQ(ParseMaxArraySize("MailProg = x\nMaxArraySize            = 4001\nMaxB = 7\n"), 4001);
  EXPECT_EQ(ParseMaxArraySize(""), 1001);
  EXPECT_EQ(ParseMaxArraySize("MaxArraySize = \nX = 9"), 1001);
  EXPECT_EQ(ParseJobState("JobId=1 JobState=NODE_FAIL Reason=None Dep=x\n"), "NODE_FAIL");
  EXPECT_EQ(ParseJobState("JobState=TIMEOUT Reason=TimeLimit\n"), "TIMEOUT (TimeLimit)");
  EXPECT_EQ(ParseJobState("slurm_load_jobs error"), "");
}

}  // namespace
}  // namespace deepslam::batch
