// Guesses of time and disk.
#include <gmock/gmock.h>

#include <numeric>

#include "deepslam/batch/forecast.h"
#include "support/temp_dir.h"

namespace deepslam::batch {
namespace {

using testing_support::TempDir;
using testing_support::WriteText;

const std::vector<std::string> kStages = {"track", "detect", "mesh"};

CaptureRecord Done(double track_s, double detect_s, double mesh_s) {
  CaptureRecord record;
  record.state = CaptureState::kDone;
  record.stage_s = {{"track", track_s}, {"detect", detect_s}, {"mesh", mesh_s}};
  record.attempt_s = track_s + detect_s + mesh_s;
  record.started_s = 1000;
  record.ended_s = 1100;
  return record;
}

double Sum(const std::map<std::string, double>& shares) {
  return std::accumulate(shares.begin(), shares.end(), 0.0, [](double sum, const auto& entry) {
    return sum + entry.second;
  });
}

TEST(Forecast, SharesComeFromWhatIsDone) {
  const std::vector<CaptureRecord> records = {Done(2, 1, 1), Done(4, 1, 1)};
  const auto shares = StageShares(records, kStages);
  EXPECT_DOUBLE_EQ(shares.at("track"), 0.6);
  EXPECT_DOUBLE_EQ(Sum(shares), 1);
  EXPECT_NEAR(Sum(StageShares({}, kStages)), 1, 1e-12);
}

TEST(Forecast, TimeLeftOfARunningCaptureFollowsItsSteps) {
  const std::vector<CaptureRecord> records = {Done(6, 2, 2)};
  const auto shares = StageShares(records, kStages);
  CaptureRecord running;
  running.state = CaptureState::kRunning;
  running.stage = "detect";
  running.done = 5;
  running.total = 10;  // 0.6 + half of 0.2 is done
  EXPECT_NEAR(*SecondsLeft(running, 7, shares, kStages), 3, 1e-9);
  running.stage = "track";
  running.done = 0;
  EXPECT_FALSE(SecondsLeft(running, 7, shares, kStages).has_value());
}

TEST(Forecast, TimeLeftOfABatchScalesWithItsJobs) {
  BatchState batch;
  batch.started_s = 1000;
  batch.captures = {Done(6, 2, 2), CaptureRecord(), CaptureRecord(), CaptureRecord(), CaptureRecord()};
  batch.jobs = 1;
  const double one = *SecondsLeft(batch, 1100);
  batch.jobs = 2;
  EXPECT_NEAR(one, 40, 1e-9);
  EXPECT_NEAR(*SecondsLeft(batch, 1100), one / 2, 1e-9);
  batch.captures[0].ended_s = 900;  // done before this call: tells nothing about its speed
  EXPECT_FALSE(SecondsLeft(batch, 1100).has_value());
}

TEST(Forecast, DiskNeedGrowsWithTheImages) {
  const TempDir dir;
  for (int i = 0; i < 20; ++i) {
    WriteText(dir.path() / "few" / "rgb" / (std::to_string(i) + ".png"), "");
    WriteText(dir.path() / "many" / "rgb" / (std::to_string(i) + ".JPG"), "");
    WriteText(dir.path() / "many" / "depth" / (std::to_string(i) + ".png"), "");
  }
  const DiskNeed few = EstimateDiskNeed(dir.path() / "few");
  const DiskNeed many = EstimateDiskNeed(dir.path() / "many");
  EXPECT_LT(few.whole, many.whole);
  EXPECT_LT(many.kept, many.whole);
  EXPECT_GT(EstimateDiskNeed(dir.path() / "missing").whole, 0U);
}

}  // namespace
}  // namespace deepslam::batch
