#include "deepslam/mapping/register_pairs.h"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deepslam/alignment/frame_alignment.h"
#include "mapping/walked_room.h"
#include "support/pose_matchers.h"

namespace deepslam::mapping {
namespace {

using ::deepslam::testing_support::PoseNear;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<Pose3> Along() {
  std::vector<Pose3> poses;
  for (int k = 0; k < 5; ++k) poses.push_back(Looking({-1 + 0.08 * k, 0.2, 1.4}, 0.3));
  return poses;
}

// Each with the next but one, from a start that is off by a few centimetres.
std::vector<KeyframePair> Pairs(const std::vector<Pose3>& truth) {
  std::vector<KeyframePair> pairs;
  for (int k = 0; k + 2 < static_cast<int>(truth.size()); ++k) {
    const auto at = static_cast<std::size_t>(k);
    Pose3 start = truth[at].Inverse() * truth[at + 2];
    start.translation_m.x() += 0.03;
    pairs.push_back({FrameIdx{k}, FrameIdx{k + 2}, start});
  }
  return pairs;
}

PairAlignment Aligned(std::size_t pairs_at_once) {
  PairAlignment alignment;
  alignment.align = [](const auto& older, const auto& newer, const Pose3& start) {
    return alignment::AlignPyramids(older, newer, {&start, 1}, {});
  };
  alignment.pairs_at_once = pairs_at_once;
  alignment.without = "not measured";
  return alignment;
}

TEST(RegisterPairs, MeasuresEachPairWhateverTheBatches) {
  const std::vector<Pose3> truth = Along();
  const dataset::MemoryFrameSource frames = SourceOf(FramesAlong({}, truth));
  const std::vector<KeyframePair> pairs = Pairs(truth);
  RecordingProgress progress;
  std::vector<std::vector<loop::KeyframeRegistration>> found;
  for (const std::size_t pairs_at_once : {1, 16}) {
    KeyframePyramids pyramids(frames, {}, 2);
    const auto registrations = RegisterPairs(pyramids, pairs, Aligned(pairs_at_once), progress);
    ASSERT_TRUE(registrations.ok());
    found.push_back(*registrations);
  }
  EXPECT_THAT(progress.warnings, IsEmpty());
  ASSERT_EQ(found[0].size(), pairs.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    EXPECT_TRUE(found[0][k].ok);
    EXPECT_THAT(found[0][k].old_from_new, PoseNear(truth[k].Inverse() * truth[k + 2], 0.005, 0.2));
    EXPECT_EQ(found[0][k].old_from_new, found[1][k].old_from_new);
    EXPECT_EQ(found[0][k].information, found[1][k].information);
  }
}

TEST(RegisterPairs, AKeyframeThatCannotBeReadIsToldAndTheOthersGoOn) {
  const std::vector<Pose3> truth = Along();
  std::vector<Frame> frames = FramesAlong({}, truth);
  MakeUnreadable(frames[4]);
  const dataset::MemoryFrameSource source = SourceOf(std::move(frames));
  RecordingProgress progress;
  KeyframePyramids pyramids(source, {}, 8);
  const auto registrations = RegisterPairs(pyramids, Pairs(truth), Aligned(16), progress);
  ASSERT_TRUE(registrations.ok());
  EXPECT_TRUE((*registrations)[0].ok);
  EXPECT_TRUE((*registrations)[1].ok);
  EXPECT_FALSE((*registrations)[2].ok);
  EXPECT_THAT(progress.warnings,
              ElementsAre(AllOf(HasSubstr("not measured"), HasSubstr("frame 4"))));
}

TEST(RegisterPairs, EndsWhenAskedTo) {
  const std::vector<Pose3> truth = Along();
  const dataset::MemoryFrameSource frames = SourceOf(FramesAlong({}, truth));
  RecordingProgress progress(2);
  KeyframePyramids pyramids(frames, {}, 8);
  const auto registrations = RegisterPairs(pyramids, Pairs(truth), Aligned(1), progress);
  ASSERT_FALSE(registrations.ok());
  EXPECT_EQ(registrations.error().code, ErrorCode::kInterrupted);
}

TEST(RegisterPairs, OfNoPairsIsNothing) {
  const dataset::MemoryFrameSource frames = SourceOf({});
  RecordingProgress progress;
  KeyframePyramids pyramids(frames, {}, 8);
  const auto registrations = RegisterPairs(pyramids, {}, Aligned(16), progress);
  ASSERT_TRUE(registrations.ok());
  EXPECT_THAT(*registrations, IsEmpty());
}

}  // namespace
}  // namespace deepslam::mapping
