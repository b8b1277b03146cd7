#include "deepslam/mapping/keyframe_pyramids.h"

#include <atomic>
#include <optional>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/alignment/reference_pixels.h"
#include "deepslam/dataset/memory_frame_source.h"

namespace deepslam::mapping {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kWidth = 32;
constexpr int kHeight = 24;

std::vector<Frame> Walls(int count) {
  std::vector<Frame> frames;
  for (int n = 0; n < count; ++n) {
    Frame frame;
    frame.time_s = 0.1 * n;
    frame.depth_m = DepthImage(kWidth, kHeight, 1.0F + 0.1F * static_cast<float>(n));
    frame.colour = ColourImage(kWidth, kHeight, {7, 8, 9});
    frames.push_back(std::move(frame));
  }
  return frames;
}

// Counts how often depth is read; one frame cannot be.
class CountedWalls final : public FrameSource {
 public:
  [[nodiscard]] int num_frames() const override { return frames_.num_frames(); }
  [[nodiscard]] const PinholeCamera& camera() const override { return frames_.camera(); }
  [[nodiscard]] double time_s(FrameIdx frame) const override { return frames_.time_s(frame); }
  [[nodiscard]] Result<Frame> Read(FrameIdx frame) const override { return frames_.Read(frame); }
  [[nodiscard]] Result<Frame> ReadDepth(FrameIdx frame) const override {
    ++reads;
    if (frame == broken) return InvalidInput("is broken");
    return frames_.ReadDepth(frame);
  }
  [[nodiscard]] Result<Frame> ReadColour(FrameIdx frame) const override {
    return frames_.ReadColour(frame);
  }
  [[nodiscard]] std::optional<Pose3> capture_world_from_camera(FrameIdx frame) const override {
    return frames_.capture_world_from_camera(frame);
  }

  FrameIdx broken;
  mutable std::atomic<int> reads = 0;

 private:
  dataset::MemoryFrameSource frames_{PinholeCamera{kWidth, kHeight, 30, 30, 15.5, 11.5}, Walls(8)};
};

std::vector<FrameIdx> Frames(std::initializer_list<int> numbers) {
  std::vector<FrameIdx> frames;
  for (const int number : numbers) frames.push_back(FrameIdx{number});
  return frames;
}

TEST(KeyframePyramids, AreMadeOnceWhileTheyAreKept) {
  const CountedWalls walls;
  KeyframePyramids pyramids(walls, {}, 3);
  EXPECT_THAT(pyramids.Hold(Frames({0, 1})), IsEmpty());
  EXPECT_THAT(pyramids.Hold(Frames({1, 2})), IsEmpty());
  EXPECT_EQ(walls.reads, 3);
  EXPECT_FLOAT_EQ(pyramids[FrameIdx{2}].levels.front().depth_m.front(), 1.2F);
  EXPECT_THAT(pyramids.Hold(Frames({0})), IsEmpty());  // still there
  EXPECT_EQ(walls.reads, 3);
  EXPECT_THAT(pyramids.Hold(Frames({3})), IsEmpty());  // instead of 1 or 2
  EXPECT_THAT(pyramids.Hold(Frames({0})), IsEmpty());
  EXPECT_EQ(walls.reads, 4);
}

TEST(KeyframePyramids, MoreThanAreKeptMayBeWanted) {
  const CountedWalls walls;
  KeyframePyramids pyramids(walls, {}, 2);
  EXPECT_THAT(pyramids.Hold(Frames({0, 1, 2, 3, 4})), IsEmpty());
  for (const int n : {0, 1, 2, 3, 4}) EXPECT_TRUE(IsReference(pyramids[FrameIdx{n}])) << n;
}

std::shared_ptr<const alignment::FramePyramid> PyramidOf(const FrameSource& frames, int frame) {
  Result<alignment::ReadFrame> read = alignment::ReadPyramid(frames, FrameIdx{frame}, {});
  EXPECT_TRUE(read.ok());
  return std::make_shared<const alignment::FramePyramid>(std::move(read->pyramid));
}

TEST(KeyframePyramids, WhatWasTakenIsNotReadAgain) {
  const CountedWalls walls;
  KeyframePyramids pyramids(walls, {}, 3);
  for (const int n : {2, 4}) pyramids.Take(FrameIdx{n}, PyramidOf(walls, n));
  walls.reads = 0;
  EXPECT_THAT(pyramids.Hold(Frames({0, 2, 4})), IsEmpty());
  EXPECT_EQ(walls.reads, 1);
  EXPECT_FLOAT_EQ(pyramids[FrameIdx{4}].levels.front().depth_m.front(), 1.4F);
  for (const int n : {0, 2, 4}) EXPECT_TRUE(IsReference(pyramids[FrameIdx{n}])) << n;
}

TEST(KeyframePyramids, WhatWillBeAskedForOutlastsWhatWas) {
  const CountedWalls walls;
  KeyframePyramids pyramids(walls, {}, 3);
  for (const int n : {0, 1, 2, 3}) pyramids.Take(FrameIdx{n}, PyramidOf(walls, n));  // 3: no room
  walls.reads = 0;
  EXPECT_THAT(pyramids.Hold(Frames({0})), IsEmpty());
  EXPECT_THAT(pyramids.Hold(Frames({5})), IsEmpty());  // instead of 0
  EXPECT_EQ(walls.reads, 1);
  EXPECT_THAT(pyramids.Hold(Frames({1, 2})), IsEmpty());
  EXPECT_EQ(walls.reads, 1);
  EXPECT_THAT(pyramids.Hold(Frames({3, 6, 7})), IsEmpty());  // all others go
  for (const int n : {3, 6, 7}) EXPECT_FALSE(pyramids[FrameIdx{n}].empty()) << n;
}

TEST(KeyframePyramids, WhatCannotBeReadIsEmptyAndTold) {
  CountedWalls walls;
  walls.broken = FrameIdx{1};
  KeyframePyramids pyramids(walls, {}, 4);
  EXPECT_THAT(pyramids.Hold(Frames({0, 1})),
              ElementsAre(testing::AllOf(HasSubstr("frame 1"), HasSubstr("broken"))));
  EXPECT_TRUE(pyramids[FrameIdx{1}].empty());
  EXPECT_FALSE(pyramids[FrameIdx{0}].empty());
  EXPECT_THAT(pyramids.Hold(Frames({1, 2})), IsEmpty());  // told once
}

}  // namespace
}  // namespace deepslam::mapping
