#include "deepslam/dataset/kept_frames.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/core/parallel.h"
#include "deepslam/dataset/memory_frame_source.h"

namespace deepslam::dataset {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;
constexpr std::size_t kDepthBytes = kWidth * kHeight * sizeof(float);  // unpacked
constexpr std::size_t kColourBytes = kWidth * kHeight * sizeof(Rgb8);
constexpr std::size_t kPlenty = 100 * (kDepthBytes + kColourBytes);
constexpr double kUnitsPerM = 1000;

// In millimetres, as sensors measure a slope, with noise.
DepthImage SlopeM(int n) {
  DepthImage depth_m(kWidth, kHeight);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const int depth_mm = 1000 + 100 * n + 3 * u + 2 * v + (u * 7 + v * 13) % 5;
      depth_m(u, v) = static_cast<float>(depth_mm / kUnitsPerM);
    }
  }
  return depth_m;
}

std::vector<Frame> SomeFrames(int count) {
  std::vector<Frame> frames;
  for (int n = 0; n < count; ++n) {
    Frame frame;
    frame.time_s = 0.1 * n;
    frame.depth_m = SlopeM(n);
    frame.colour = ColourImage(kWidth, kHeight, {static_cast<std::uint8_t>(n), 2, 3});
    frames.push_back(std::move(frame));
  }
  return frames;
}

// Counts how often images are really read.
class CountedFrames final : public FrameSource {
 public:
  CountedFrames(int count, std::vector<int>& reads) : CountedFrames(SomeFrames(count), reads) {}
  CountedFrames(std::vector<Frame> frames, std::vector<int>& reads)
      : frames_(PinholeCamera{kWidth, kHeight, 5, 5, 3.5, 2.5}, std::move(frames)), reads_(reads) {
    reads_.assign(static_cast<std::size_t>(frames_.num_frames()), 0);
  }
  [[nodiscard]] int num_frames() const override { return frames_.num_frames(); }
  [[nodiscard]] const PinholeCamera& camera() const override { return frames_.camera(); }
  [[nodiscard]] double time_s(FrameIdx frame) const override { return frames_.time_s(frame); }
  [[nodiscard]] Result<Frame> Read(FrameIdx frame) const override {
    Count(frame);
    return frames_.Read(frame);
  }
  [[nodiscard]] Result<Frame> ReadDepth(FrameIdx frame) const override {
    Count(frame);
    if (frame == broken) return InvalidInput("broken");
    return frames_.ReadDepth(frame);
  }
  [[nodiscard]] Result<Frame> ReadColour(FrameIdx frame) const override {
    Count(frame);
    return frames_.ReadColour(frame);
  }
  [[nodiscard]] std::optional<Pose3> capture_world_from_camera(FrameIdx frame) const override {
    return frames_.capture_world_from_camera(frame);
  }

  FrameIdx broken;

 private:
  void Count(FrameIdx frame) const { ++reads_[static_cast<std::size_t>(frame.value)]; }

  MemoryFrameSource frames_;
  std::vector<int>& reads_;
};

std::unique_ptr<FrameSource> Keep(std::unique_ptr<FrameSource> frames, std::size_t max_bytes) {
  return KeepFrames(std::move(frames), kUnitsPerM, max_bytes);
}

void ExpectFrame(const Result<Frame>& frame, int n) {
  ASSERT_TRUE(frame.ok());
  const Frame expected = SomeFrames(n + 1).back();
  EXPECT_EQ(frame->idx, FrameIdx{n});
  EXPECT_DOUBLE_EQ(frame->time_s, expected.time_s);
  EXPECT_EQ(frame->depth_m, expected.depth_m);
  EXPECT_EQ(frame->colour, expected.colour);
}

TEST(KeepFrames, GivesEqualFramesAndReadsThemTwiceAtMost) {
  std::vector<int> reads;
  const auto kept = Keep(std::make_unique<CountedFrames>(3, reads), kPlenty);
  for (int turn = 0; turn < 5; ++turn) {
    for (int n = 0; n < 3; ++n) ExpectFrame(kept->Read({n}), n);
  }
  EXPECT_EQ(reads, (std::vector<int>{4, 4, 4})) << "depth and colour, twice each";
}

// Of the source, whether the colour is kept by then or not: it may be rounded in its own way.
TEST(KeepFrames, IntensityIsTheSourcesOwn) {
  std::vector<int> reads;
  const auto kept = Keep(std::make_unique<CountedFrames>(1, reads), kPlenty);
  for (int turn = 0; turn < 4; ++turn) {
    const int before = reads[0];
    ASSERT_TRUE(kept->ReadIntensity({0}, 2).ok());
    EXPECT_EQ(reads[0], before + 1);
    ASSERT_TRUE(kept->ReadColour({0}).ok());
  }
}

TEST(KeepFrames, KeepsDepthAndColourForThemselves) {
  std::vector<int> reads;
  const auto kept = Keep(std::make_unique<CountedFrames>(1, reads), kPlenty);
  for (int turn = 0; turn < 4; ++turn) {
    const Result<Frame> depth = kept->ReadDepth({0});
    ASSERT_TRUE(depth.ok());
    EXPECT_TRUE(depth->colour.empty());
  }
  EXPECT_EQ(reads[0], 2);
  ExpectFrame(kept->Read({0}), 0);
  EXPECT_EQ(reads[0], 3) << "colour alone was missing";
}

// Kept as it is, packed, and not at all.
TEST(KeepFrames, StoredDepthIsTheSameAndKeptAlike) {
  for (const std::size_t max_bytes : {kPlenty, 2 * kDepthBytes, std::size_t{0}}) {
    std::vector<int> reads;
    const auto kept = Keep(std::make_unique<CountedFrames>(8, reads), max_bytes);
    for (int turn = 0; turn < 4; ++turn) {
      for (int n = 0; n < 8; ++n) {
        Result<StoredDepth> depth = kept->ReadStoredDepth({n});
        ASSERT_TRUE(depth.ok());
        EXPECT_EQ((*std::move(depth)).TakeMetres(), SlopeM(n)) << "turn " << turn;
      }
    }
    EXPECT_EQ(reads, std::vector<int>(8, max_bytes > 0 ? 2 : 4));
  }
}

TEST(KeepFrames, KeepsNoMoreThanTheMemoryGiven) {
  std::vector<int> reads;
  const auto kept = Keep(std::make_unique<CountedFrames>(10, reads), 3 * kColourBytes);
  for (int turn = 0; turn < 4; ++turn) {
    for (int n = 0; n < 10; ++n) ASSERT_TRUE(kept->ReadColour({n}).ok());
  }
  int num_kept = 0;
  for (const int count : reads) num_kept += count == 2 ? 1 : 0;
  EXPECT_EQ(num_kept, 3);
  const auto none = Keep(std::make_unique<CountedFrames>(1, reads), 0);
  for (int turn = 0; turn < 4; ++turn) ExpectFrame(none->Read({0}), 0);
  EXPECT_EQ(reads[0], 8);
}

// Packed, when there is no room for the third one.
TEST(KeepFrames, DepthTakesAFractionOfItsPixels) {
  std::vector<int> reads;
  const auto kept = Keep(std::make_unique<CountedFrames>(8, reads), 2 * kDepthBytes);
  for (int turn = 0; turn < 4; ++turn) {
    for (int n = 0; n < 8; ++n) EXPECT_EQ(kept->ReadDepth({n})->depth_m, SlopeM(n));
  }
  EXPECT_EQ(reads, std::vector<int>(8, 2));
}

TEST(KeepFrames, DepthMakesRoomForColour) {
  std::vector<int> reads;
  const auto kept = Keep(std::make_unique<CountedFrames>(3, reads), 3 * kDepthBytes);
  for (int n = 0; n < 3; ++n) kept->GiveBack(*kept->ReadDepth({n}));
  for (int turn = 0; turn < 4; ++turn) ExpectFrame(kept->Read({0}), 0);
  EXPECT_EQ(reads, (std::vector<int>{1 + 2, 1, 1}));
}

TEST(KeepFrames, DepthThatCannotBePackedMakesNoRoom) {
  std::mt19937 random(1);
  std::vector<Frame> frames = SomeFrames(3);
  for (Frame& frame : frames) {
    for (float& depth : frame.depth_m)
      depth = std::bit_cast<float>(static_cast<std::uint32_t>(random()) & 0x3fffffffU);
  }
  std::vector<int> reads;
  const auto kept = Keep(std::make_unique<CountedFrames>(frames, reads), kDepthBytes);
  for (int turn = 0; turn < 4; ++turn) {
    for (int n = 0; n < 3; ++n)
      EXPECT_EQ(kept->ReadDepth({n})->depth_m, frames[static_cast<std::size_t>(n)].depth_m);
  }
  EXPECT_EQ(reads, (std::vector<int>{2, 4, 4}));
}

// One kind of images may find room where the other does not.
TEST(KeepFrames, DepthIsKeptWhereColourIsTooLarge) {
  std::vector<int> reads;
  const auto kept = Keep(std::make_unique<CountedFrames>(1, reads), kColourBytes - 1);
  for (int turn = 0; turn < 4; ++turn) ExpectFrame(kept->Read({0}), 0);
  EXPECT_EQ(reads[0], 2 + 4);
}

TEST(KeepFrames, WhatIsGivenBackIsNotReadAgain) {
  std::vector<int> reads;
  const auto kept = Keep(std::make_unique<CountedFrames>(3, reads), kPlenty);
  kept->GiveBack(*kept->ReadDepth({0}));
  kept->GiveBack(*kept->ReadColour({1}));
  kept->GiveBack(*kept->Read({2}));
  for (int turn = 0; turn < 4; ++turn) {
    EXPECT_EQ(kept->ReadDepth({0})->depth_m, SomeFrames(1)[0].depth_m);
    EXPECT_EQ(kept->ReadColour({1})->colour, SomeFrames(2)[1].colour);
    ExpectFrame(kept->Read({2}), 2);
  }
  EXPECT_EQ(reads, (std::vector<int>{1, 1, 2}));
}

TEST(KeepFrames, NoMoreIsGivenBackThanThereIsMemoryFor) {
  std::vector<int> reads;
  const auto kept = Keep(std::make_unique<CountedFrames>(2, reads), kColourBytes);
  for (const int n : {0, 1}) {
    Result<Frame> colour = kept->ReadColour({n});
    ASSERT_TRUE(colour.ok());
    kept->GiveBack(std::move(colour).value());
    ASSERT_TRUE(kept->ReadColour({n}).ok());
  }
  EXPECT_EQ(reads, (std::vector<int>{1, 2}));
}

TEST(KeepFrames, AnErrorIsNotKept) {
  std::vector<int> reads;
  auto source = std::make_unique<CountedFrames>(2, reads);
  CountedFrames* const inner = source.get();
  const auto kept = Keep(std::move(source), kPlenty);
  inner->broken = {1};
  EXPECT_FALSE(kept->Read({1}).ok());
  EXPECT_FALSE(kept->Read({1}).ok());
  inner->broken = FrameIdx();
  for (int turn = 0; turn < 3; ++turn) ExpectFrame(kept->Read({1}), 1);
}

TEST(KeepFrames, ManyThreadsGetTheSameFrames) {
  const auto kept = Keep(std::make_unique<MemoryFrameSource>(
                             PinholeCamera{kWidth, kHeight, 5, 5, 3.5, 2.5}, SomeFrames(7)),
                         4 * kColourBytes);
  std::vector<int> wrong(200, 0);
  ParallelFor(wrong.size(), [&](std::size_t i) {
    const int n = static_cast<int>(i) % 7;
    const Result<Frame> frame = kept->Read({n});
    wrong[i] = frame.ok() && frame->depth_m == SlopeM(n) ? 0 : 1;
  });
  EXPECT_EQ(wrong, std::vector<int>(200, 0));
}

}  // namespace
}  // namespace deepslam::dataset
