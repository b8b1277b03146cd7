// Silhouettes of a map's objects against segments of a rendered box: where it stands they agree,
// beside it less, and what is hidden or unusable says nothing.
#include "deepslam/eval/map_silhouettes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/box_meshes.h"
#include "support/box_world.h"

namespace deepslam::eval {
namespace {

using testing_support::BoxMesh;
using testing_support::BoxWorldSource;
using testing_support::Cuboid;

constexpr int kFrames = 4;
const Cuboid kBox = {0, {-0.3, -0.2, 0}, {0.3, 0.2, 0.8}};

class CompareSilhouettesTest : public testing::Test {
 protected:
  CompareSilhouettesTest()
      : frames_({kBox}, testing_support::Orbit({0, 0, 0.4}, 2, 1.2, 20, 40, kFrames)) {
    ObjectTrack track{ObjectId{4}, "box", {}, ""};
    for (int k = 0; k < kFrames; ++k) {
      const testing_support::BoxView& view = frames_.View({k});
      Mask mask(view.object.width(), view.object.height());
      for (int v = 0; v < mask.height(); ++v) {
        for (int u = 0; u < mask.width(); ++u) mask(u, v) = view.object(u, v) == 0 ? 1 : 0;
      }
      Segment segment;
      segment.detection = DetectionId{10 + k};
      segment.frame = FrameIdx{k};
      segment.mask = PixelMask(mask);
      segment.usable = true;
      segments_.push_back(segment);
      track.members.push_back({segment.detection, segment.frame, 0, 0, "vote"});
    }
    association_.tracks.push_back(track);
    map_.frames = frames_.TrueOdometry().frames;
    MapObject object;
    object.id = ObjectId{4};
    object.class_name = "box";
    object.world_from_object.translation_m = {0, 0, 0.4};
    map_.map.objects.push_back(object);
  }

  [[nodiscard]] Result<SilhouetteReport> Compare() {
    return CompareSilhouettes({map_, meshes_, association_, segments_}, frames_, progress_);
  }

  BoxWorldSource frames_;
  OptimizedMap map_;
  Association association_;
  std::vector<Segment> segments_;
  std::vector<TriangleMesh> meshes_ = {BoxMesh({0.6F, 0.4F, 0.8F})};
  SilentProgress progress_;
};

TEST_F(CompareSilhouettesTest, TheTruthCoversItsSegments) {
  const Result<SilhouetteReport> report = Compare();
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report->num_views, kFrames);
  ASSERT_EQ(report->objects.size(), 1U);
  EXPECT_EQ(report->objects[0].name, "box_04");
  EXPECT_GT(report->median_iou, 0.97);  // a pixel round 60 x 90
  EXPECT_EQ(report->lowest_object_iou, report->objects[0].median_iou);
}

TEST_F(CompareSilhouettesTest, TheFurtherBesideTheLess) {
  double before = 1;
  for (const double beside_m : {0.02, 0.1, 0.3}) {
    map_.map.objects[0].world_from_object.translation_m.x() = beside_m;
    const double iou = Compare()->median_iou_all_px;
    EXPECT_LT(iou, before) << beside_m;
    before = iou;
  }
}

TEST_F(CompareSilhouettesTest, UnusableSegmentsAndBrokenFramesAreNoViews) {
  segments_[1].usable = false;
  frames_.broken = {2};
  EXPECT_EQ(Compare()->num_views, kFrames - 2);
}

TEST_F(CompareSilhouettesTest, AnObjectThatNothingWasSegmentedOfHasNoViews) {
  association_.tracks.clear();
  const Result<SilhouetteReport> report = Compare();
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report->num_views, 0);
  EXPECT_EQ(report->median_iou, 0);
  EXPECT_TRUE(report->objects[0].ious.empty());
}

class Stopped final : public Progress {
 public:
  void Report(std::size_t, std::size_t) override {}
  void Warn(std::string_view) override {}
  [[nodiscard]] bool StopRequested() const override { return true; }
};

TEST_F(CompareSilhouettesTest, EndsWhenAskedTo) {
  Stopped stopped;
  const auto report =
      CompareSilhouettes({map_, meshes_, association_, segments_}, frames_, stopped);
  EXPECT_EQ(report.error().code, ErrorCode::kInterrupted);
}

}  // namespace
}  // namespace deepslam::eval
