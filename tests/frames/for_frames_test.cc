#include "deepslam/frames/for_frames.h"

#include <optional>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deepslam/core/parallel.h"
#include "support/recording_progress.h"

namespace deepslam {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing_support::RecordingProgress;

// A pixel each, whose depth is the frame's number; frame 2 cannot be read.
class Pixels final : public FrameSource {
 public:
  [[nodiscard]] int num_frames() const override { return 20; }
  [[nodiscard]] const PinholeCamera& camera() const override { return camera_; }
  [[nodiscard]] double time_s(FrameIdx frame) const override { return frame.value; }
  [[nodiscard]] Result<Frame> Read(FrameIdx frame) const override {
    if (frame == FrameIdx{2}) return InvalidInput("depth/2.png ends too early");
    return Frame{frame, 0, {}, DepthImage(1, 1, static_cast<float>(frame.value))};
  }
  [[nodiscard]] Result<Frame> ReadDepth(FrameIdx frame) const override { return Read(frame); }
  [[nodiscard]] Result<Frame> ReadColour(FrameIdx frame) const override { return Read(frame); }
  [[nodiscard]] std::optional<Pose3> capture_world_from_camera(FrameIdx) const override {
    return std::nullopt;
  }

 private:
  PinholeCamera camera_{1, 1, 1, 1, 0, 0};
};

std::vector<FrameIdx> Numbers(std::initializer_list<int> numbers) {
  std::vector<FrameIdx> frames;
  for (const int number : numbers) frames.push_back(FrameIdx{number});
  return frames;
}

TEST(ForFrames, GivesFramesInTheOrderAskedForAndTellsOfThoseItCannotRead) {
  for (const int threads : {1, 4}) {
    const ThreadLimit limit(threads);
    RecordingProgress progress;
    std::vector<float> depths;
    const Status status = ForFrames(
        Pixels(), Numbers({5, 1, 2, 7, 0, 3, 4, 6, 8, 19, 9}), progress, [&](const Frame& frame) {
          depths.push_back(frame.depth_m(0, 0));
          return Ok();
        });
    EXPECT_TRUE(status.ok());
    EXPECT_THAT(depths, ElementsAre(5, 1, 7, 0, 3, 4, 6, 8, 19, 9));
    EXPECT_THAT(progress.warnings, ElementsAre(HasSubstr("frame 2 skipped: depth/2.png")));
    EXPECT_EQ(progress.last_done, 11u);
    EXPECT_EQ(progress.last_total, 11u);
  }
}

TEST(ForFrames, EndsWithTheFirstErrorOfItsUser) {
  RecordingProgress progress;
  int num_used = 0;
  const Status status =
      ForFrames(Pixels(), Numbers({0, 1, 3, 4}), progress, [&](const Frame& frame) -> Status {
        ++num_used;
        if (frame.idx == FrameIdx{1}) return Failed("full");
        return Ok();
      });
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().message, "full");
  EXPECT_EQ(num_used, 2);
}

TEST(ForFrames, EndsWhenAskedTo) {
  RecordingProgress progress(3);
  int num_used = 0;
  const Status status =
      ForFrames(Pixels(), Numbers({0, 1, 3, 4}), progress, [&](const Frame&) -> Status {
        ++num_used;
        return Ok();
      });
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kInterrupted);
  EXPECT_EQ(num_used, 2);
}

}  // namespace
}  // namespace deepslam
