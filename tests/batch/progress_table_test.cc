// The table of a batch at work.
#include <gmock/gmock.h>

#include "deepslam/batch/progress_table.h"

namespace deepslam::batch {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::vector<std::string> kStages = {"track", "mesh"};

BatchState Room(int num_running, int num_failed) {
  BatchState batch;
  batch.started_s = 1000;
  batch.jobs = num_running;
  for (int i = 0; i < num_running + num_failed; ++i) {
    CaptureRecord record;
    record.name = "room" + std::to_string(i);
    record.state = i < num_running ? CaptureState::kRunning : CaptureState::kFailed;
    record.started_s = 1000;
    record.ended_s = 1000 + i;
    record.stage = i < num_running ? "track" : "";
    record.done = 30;
    record.total = 120;
    record.reason = "capture.yaml:3: fx is\n0";
    batch.captures.push_back(std::move(record));
  }
  return batch;
}

std::string Joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

TEST(ProgressTable, TellsWhatRunsAndWhatFailed) {
  const std::string text = Joined(RenderTable(Room(2, 1), kStages, 1060, {100, 24}));
  EXPECT_THAT(text, AllOf(HasSubstr("0 of 3 done, 1 failed, 2 running"), HasSubstr("30/120")));
  EXPECT_THAT(text, AllOf(HasSubstr("room0"), HasSubstr("track"), HasSubstr("left")));
  EXPECT_THAT(text, HasSubstr("failed   room2"));
}

TEST(ProgressTable, ReasonsAreShownWithoutTheCapturesPath) {
  BatchState batch = Room(1, 1);
  batch.captures[1].capture = "/data/rooms/room1";
  batch.captures[1].reason = "/data/rooms/room1/capture.yaml:3: fx is 0";
  const std::string text = Joined(RenderTable(batch, kStages, 1060, {100, 24}));
  EXPECT_THAT(text, AllOf(HasSubstr("room1     capture.yaml:3"), Not(HasSubstr("/data"))));
}

TEST(ProgressTable, FitsTheTerminal) {
  for (const int width : {10, 40, 80}) {
    for (const int height : {4, 10, 24}) {
      const auto lines = RenderTable(Room(30, 30), kStages, 1060, {width, height});
      EXPECT_LT(lines.size(), static_cast<std::size_t>(height));
      for (const std::string& line : lines) EXPECT_LE(line.size(), static_cast<std::size_t>(width));
    }
  }
}

TEST(ProgressTable, LastFailuresAreShown) {
  const std::string text = Joined(RenderTable(Room(1, 30), kStages, 1060, {80, 24}));
  EXPECT_THAT(text, AllOf(HasSubstr("room30"), Not(HasSubstr("room20 "))));
}

TEST(ProgressTable, NamesCannotWriteToTheTerminal) {
  BatchState batch = Room(1, 1);
  batch.captures[1].reason = "bad \033[2J name\r";
  const std::string text = Joined(RenderTable(batch, kStages, 1060, {80, 24}));
  EXPECT_THAT(text, Not(HasSubstr("\033")));
  EXPECT_THAT(text, Not(HasSubstr("\r")));
}

TEST(ProgressTable, CutsBetweenCharacters) {
  BatchState batch = Room(1, 0);
  batch.captures[0].name = "k\xC3\xBC\xC3\xBC\xC3\xBC\xC3\xBC"
                           "che";
  for (int width = 10; width < 20; ++width) {
    const std::string line = RenderTable(batch, kStages, 1060, {width, 24})[1];
    const bool starts_or_plain = (static_cast<unsigned char>(line.back()) & 0x80U) == 0 ||
                                 line.substr(line.size() - 2) == "\xC3\xBC";
    EXPECT_TRUE(starts_or_plain) << line;
  }
}

TEST(ProgressTable, Durations) {
  EXPECT_EQ(DurationText(41.2), "41 s");
  EXPECT_EQ(DurationText(192), "3 min 12 s");
  EXPECT_EQ(DurationText(7500), "2 h 05 min");
  EXPECT_EQ(DurationText(-3), "0 s");
}

}  // namespace
}  // namespace deepslam::batch
