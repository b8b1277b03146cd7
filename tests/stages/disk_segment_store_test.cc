#include "deepslam/stages/disk_segment_store.h"

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "artifact/sample_values.h"
#include "deepslam/core/progress.h"
#include "support/temp_dir.h"

namespace deepslam::stages {
namespace {

using testing_support::SampleMask;
using testing_support::SegmentsText;
using testing_support::TempDir;
using testing_support::WriteText;

// Of a mask each, but for every third, which has none.
std::vector<Segment> SampleSegments(int count) {
  std::vector<Segment> segments;
  for (int n = 0; n < count; ++n) {
    Segment segment;
    segment.detection = DetectionId{n};
    segment.frame = FrameIdx{n / 2};
    segment.class_name = n % 2 == 0 ? "chair" : "table";
    segment.score = 0.5;
    segment.box_px = {1, 2, 30, 40};
    if (n % 3 != 2) segment.mask = SampleMask(64, 32 + n);
    segments.push_back(segment);
  }
  return segments;
}

Result<std::shared_ptr<const DiskSegmentStore>> Read(const std::string& text,
                                                     const std::filesystem::path& workspace) {
  std::filesystem::create_directories(workspace / "associate");
  std::filesystem::create_directories(workspace / "own");
  WriteText(workspace / "associate" / "segments.json", text);
  SilentProgress progress;
  const pipeline::StageContext context(workspace, workspace / "own", {"associate"}, progress);
  return DiskSegmentStore::Read(context);
}

TEST(DiskSegmentStore, GiveBackTheMasksOfThoseThatAreWanted) {
  const TempDir dir;
  const std::vector<Segment> all = SampleSegments(20);
  const auto store = Read(*SegmentsText(all), dir.path());
  ASSERT_TRUE(store.ok()) << store.error().message;
  ASSERT_EQ((*store)->without_masks().size(), all.size());
  for (std::size_t n = 0; n < all.size(); ++n) {
    EXPECT_EQ((*store)->without_masks()[n].detection, all[n].detection);
    EXPECT_TRUE((*store)->without_masks()[n].mask.empty());
  }
  const Result<std::vector<Segment>> some =
      (*store)->Of({DetectionId{17}, DetectionId{0}, DetectionId{7}, DetectionId{99}});
  ASSERT_TRUE(some.ok()) << some.error().message;
  ASSERT_EQ(some->size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t n = std::vector<std::size_t>{0, 7, 17}[k];
    EXPECT_EQ((*some)[k].detection, all[n].detection);
    EXPECT_EQ((*some)[k].frame, all[n].frame);
    EXPECT_EQ((*some)[k].mask, all[n].mask);
  }
  EXPECT_TRUE((*store)->Of({})->empty());
}

TEST(DiskSegmentStore, PassOnWhatIsWrongWithTheFile) {
  const TempDir dir;
  const std::string text = *SegmentsText(SampleSegments(4));
  const auto cut = Read(text.substr(0, text.size() / 2), dir.path());
  ASSERT_FALSE(cut.ok());
  EXPECT_NE(cut.error().message.find("associate/segments.json"), std::string::npos);
}

}  // namespace
}  // namespace deepslam::stages
