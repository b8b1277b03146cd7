#include "deepslam/discovery/associate_capture.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "deepslam/fuse/coarse_fusion.h"
#include "support/box_world.h"

namespace deepslam::discovery {
namespace {

using testing::SizeIs;
using namespace testing_support;  // NOLINT

Mask MaskOf(const BoxView& view, const std::vector<int>& objects) {
  Mask mask(view.object.width(), view.object.height());
  for (std::size_t p = 0; p < mask.size(); ++p)
    mask.data()[p] = std::ranges::count(objects, view.object.data()[p]) > 0 ? 1 : 0;
  return mask;
}

// Of a capture in a level world all of whose frames the detector looked at.
Result<FoundThings> Associated(const BoxWorldSource& source,
                               const ClassTable& classes,
                               const std::vector<Detection>& detections,
                               std::vector<Segment> segments,
                               const std::optional<SurfaceOfCapture>& surface,
                               const Layout& layout) {
  const Odometry odometry = source.TrueOdometry();
  const std::vector<int> part_of_frame(odometry.frames.size(), 0);
  const Ground ground;
  std::vector<FrameIdx> looked_at;
  for (int f = 0; f < source.num_frames(); ++f) looked_at.push_back({f});
  SilentProgress progress;
  return AssociateCapture(
      {source, odometry, part_of_frame, ground, classes, looked_at, detections, surface, layout},
      std::move(segments),
      {},
      {},
      progress);
}

// A wall with a television and a poster on it.
class TelevisionAndPoster : public testing::Test {
 protected:
  static constexpr int kTelevision = 0;
  static constexpr int kPoster = 1;
  static constexpr double kWall_m = 2.0;  // y of its face

  static std::vector<Cuboid> World() {
    return {{-1, {-3, kWall_m, 0}, {3, kWall_m + 0.2, 2.5}},
            {kTelevision, {-0.6, kWall_m - 0.08, 1.2}, {0.2, kWall_m, 1.7}},
            {kPoster, {0.8, kWall_m - 0.003, 1.2}, {1.4, kWall_m, 1.7}}};
  }
  static std::vector<Pose3> Walk() {
    std::vector<Pose3> poses;
    for (const double x : {-0.3, 0.0, 0.3, 0.6, 0.9, 1.2})
      poses.push_back(LookAt({x, -0.6, 1.4}, {0.4, kWall_m, 1.4}));
    return poses;
  }

  // The objects that have a track; detections call both of them televisions.
  [[nodiscard]] std::vector<int> Tracked(const Layout& layout) const {
    ClassTable classes;
    classes.classes.resize(1);
    classes.classes[0].name = "tv";
    classes.classes[0].traits.supports = {.floor = false, .furniture = true, .wall = true};
    std::vector<Segment> segments;
    std::map<DetectionId, int> truth;
    for (int f = 0; f < source_.num_frames(); ++f) {
      for (const int object : {kTelevision, kPoster}) {
        Segment segment;
        segment.detection = {static_cast<int>(segments.size())};
        segment.frame = {f};
        segment.class_name = "tv";
        segment.score = 0.8;
        segment.box_px = DetectTruth(source_.View({f}), object, "tv")->box_px;
        segment.mask = MaskOf(source_.View({f}), {object});
        segment.usable = true;
        truth[segment.detection] = object;
        segments.push_back(std::move(segment));
      }
    }
    const Result<FoundThings> found =
        Associated(source_, classes, {}, segments, std::nullopt, layout);
    EXPECT_TRUE(found.ok());
    std::vector<int> objects;
    for (const ObjectTrack& track : found->association.tracks)
      objects.push_back(truth.at(track.members.front().detection));
    return objects;
  }

  BoxWorldSource source_{World(), Walk()};
};

TEST_F(TelevisionAndPoster, WhatLiesFlushInAWallIsNoObject) {
  Layout layout;
  EXPECT_THAT(Tracked(layout), testing::UnorderedElementsAre(kTelevision, kPoster))
      << "no wall is known";
  LayoutWall wall;
  wall.from_m = {3, kWall_m};
  wall.to_m = {-3, kWall_m};
  wall.top_m = 2.5;
  layout.walls.push_back(wall);
  EXPECT_THAT(Tracked(layout), testing::ElementsAre(kTelevision));
}

SurfaceOfCapture SurfaceOf(const BoxWorldSource& source) {
  fuse::CoarseFusion fusion({});
  for (int f = 0; f < source.num_frames(); ++f) {
    const Pose3 level_from_camera = *source.capture_world_from_camera({f});
    EXPECT_TRUE(fusion.Integrate(source.View({f}).frame, source.camera(), level_from_camera).ok());
  }
  SurfaceOfCapture surface{std::move(fusion).Take(), {}};
  surface.surface.has_ground = true;
  return surface;
}

// Masks of detections hold what stands on a table, and the surface that they divide does then.
TEST(AssociateCapture, SilhouettesOfATableAreWithoutWhatStandsOnIt) {
  constexpr int kTable = 0;
  constexpr int kBox = 1;
  std::vector<Cuboid> world = TableAt(kTable, 0, 0);
  world.push_back({kBox, {-0.3, -0.1, 0.74}, {0.0, 0.2, 0.86}});
  const BoxWorldSource source(world, Orbit({0, 0, 0.5}, 2.4, 1.6, 10, 30, 12));
  std::vector<Detection> detections;
  for (int f = 0; f < source.num_frames(); ++f) {
    const BoxView& view = source.View({f});
    detections.push_back(*DetectTruth(view, kTable, "table"));
    detections.back().id = {f};
    detections.back().mask = MaskOf(view, {kTable, kBox});
  }
  ClassTable classes;
  classes.classes = {
      {"table", {"dining table"}, {}, 0.4, 4, 0.3, 1.2, {}, {.support_plane = true}}};
  const Result<FoundThings> found =
      Associated(source, classes, detections, {}, SurfaceOf(source), {});
  ASSERT_TRUE(found.ok());
  ASSERT_THAT(found->association.tracks, SizeIs(1));
  EXPECT_THAT(found->segments, SizeIs(source.num_frames()));
  std::map<int, double> shown;  // pixels by object
  std::map<int, double> taken;
  for (const Segment& segment : found->segments) {
    const Mask mask = segment.mask.Unpacked();
    const Image<int>& object = source.View(segment.frame).object;
    for (std::size_t p = 0; p < mask.size(); ++p) {
      ++shown[object.data()[p]];
      if (mask.data()[p] != 0) ++taken[object.data()[p]];
    }
  }
  EXPECT_LT(taken[kBox], 0.25 * shown[kBox]);
  EXPECT_GT(taken[kTable], 0.75 * shown[kTable]);
}

// Keyframes are its views, those of a user's file too; in all others the detector votes.
TEST(AssociateCapture, FramesThatTheDetectorAloneLookedAtOnlyVote) {
  constexpr int kTable = 0;
  const BoxWorldSource source(TableAt(kTable, 0, 0), Orbit({0, 0, 0.5}, 2.4, 1.6, 10, 30, 12));
  Odometry odometry = source.TrueOdometry();
  odometry.keyframes = {FrameIdx{0}, FrameIdx{4}, FrameIdx{8}};
  std::vector<FrameIdx> looked_at;
  std::vector<Detection> detections;
  for (const int f : {0, 1, 4, 6, 8, 9}) {
    looked_at.push_back({f});
    detections.push_back(*DetectTruth(source.View({f}), kTable, "table"));
    detections.back().id = {f};
    detections.back().score = 0.5;
    detections.back().source = f == 6 ? DetectionSource::kFile : DetectionSource::kNetwork;
  }
  ClassTable classes;
  classes.classes = {
      {"table", {"dining table"}, {}, 0.4, 4, 0.3, 1.2, {}, {.support_plane = true}}};
  const std::vector<int> part_of_frame(odometry.frames.size(), 0);
  SilentProgress progress;
  const std::optional<SurfaceOfCapture> surface = SurfaceOf(source);
  const Result<FoundThings> found = AssociateCapture(
      {source, odometry, part_of_frame, {}, classes, looked_at, detections, surface, {}},
      {},
      {},
      {},
      progress);
  ASSERT_TRUE(found.ok());
  ASSERT_THAT(found->association.tracks, SizeIs(1));
  EXPECT_NEAR(found->association.tracks[0].class_votes.at("table"), 6 * 0.5, 1e-9);
  EXPECT_THAT(found->segments,
              testing::ElementsAre(testing::Field(&Segment::frame, FrameIdx{0}),
                                   testing::Field(&Segment::frame, FrameIdx{4}),
                                   testing::Field(&Segment::frame, FrameIdx{6}),
                                   testing::Field(&Segment::frame, FrameIdx{8})));
  EXPECT_THAT(found->association.rejections, testing::IsEmpty());  // all name the table
}

}  // namespace
}  // namespace deepslam::discovery
