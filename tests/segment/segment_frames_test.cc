#include "deepslam/segment/segment_frames.h"

#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "deepslam/core/parallel.h"
#include "support/box_world.h"
#include "support/recording_progress.h"

namespace deepslam::segment {
namespace {

using testing_support::BoxWorldSource;
using testing_support::Cuboid;
using testing_support::DetectTruth;
using testing_support::MaskIoU;
using testing_support::Orbit;
using testing_support::RecordingProgress;

constexpr int kNumFrames = 12;  // more than are held at a time

const std::vector<Cuboid> kWorld = {{0, {-0.4, -0.25, 0}, {0.4, 0.25, 0.6}},
                                    {1, {-0.2, 0.6, 0}, {0.2, 1.0, 0.5}}};

// Two things, seen from all round and detected in every frame.
struct Scene {
  Scene() : source(kWorld, Orbit({0, 0.3, 0.3}, 2.2, 1.4, -90, 15, kNumFrames)) {
    ground.plane_world = Plane{};
    for (int k = 0; k < kNumFrames; ++k) {
      for (const int object : {0, 1}) {
        Detection detection = *DetectTruth(source.View(FrameIdx{k}), object, "thing");
        detection.id = DetectionId{static_cast<int>(detections.size())};
        detections.push_back(std::move(detection));
      }
    }
    options.min_points = 100;  // a quarter of the default, as are the images
  }

  Result<std::vector<Segment>> Segments(Progress& progress) const {
    return SegmentFrames({source, path, ground, classes, detections}, options, progress);
  }

  BoxWorldSource source;
  Odometry path = source.TrueOdometry();
  Ground ground;
  ClassTable classes;
  std::vector<Detection> detections;
  SegmentOptions options;
};

TEST(SegmentFrames, GivesTheSilhouetteOfEachDetectionInTheirOrder) {
  const Scene scene;
  RecordingProgress progress;
  const auto segments = scene.Segments(progress);
  ASSERT_TRUE(segments.ok());
  ASSERT_EQ(segments->size(), scene.detections.size());
  for (std::size_t n = 0; n < segments->size(); ++n) {
    const Segment& segment = (*segments)[n];
    EXPECT_EQ(segment.detection, scene.detections[n].id);
    EXPECT_TRUE(segment.usable);
    EXPECT_GT(MaskIoU(segment.mask, scene.source.View(segment.frame), static_cast<int>(n % 2)), 0.8)
        << n;
  }
  EXPECT_EQ(progress.last_done, static_cast<std::size_t>(kNumFrames));
}

TEST(SegmentFrames, OfAFrameThatCannotBeReadThereIsNothing) {
  Scene scene;
  scene.source.broken = {4};
  RecordingProgress progress;
  const auto segments = scene.Segments(progress);
  ASSERT_TRUE(segments.ok());
  EXPECT_EQ(segments->size(), scene.detections.size() - 2);
  for (const Segment& segment : *segments) EXPECT_NE(segment.frame, FrameIdx{4});
}

TEST(SegmentFrames, EndsWhenAskedTo) {
  const Scene scene;
  RecordingProgress progress(5);
  const auto segments = scene.Segments(progress);
  ASSERT_FALSE(segments.ok());
  EXPECT_EQ(segments.error().code, ErrorCode::kInterrupted);
}

TEST(SegmentFrames, TheNumberOfThreadsChangesNothing) {
  const Scene scene;
  const auto segment = [&](int threads) {
    const ThreadLimit limit(threads);
    RecordingProgress progress;
    return *scene.Segments(progress);
  };
  const std::vector<Segment> one = segment(1);
  const std::vector<Segment> four = segment(4);
  ASSERT_EQ(one.size(), four.size());
  for (std::size_t n = 0; n < one.size(); ++n) EXPECT_EQ(one[n].mask, four[n].mask);
}

}  // namespace
}  // namespace deepslam::segment
