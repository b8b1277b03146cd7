#include "deepslam/discovery/find_things.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "deepslam/core/parallel.h"
#include "deepslam/fuse/coarse_fusion.h"
#include "support/box_world.h"

namespace deepslam::discovery {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using namespace testing_support;  // NOLINT

// A table with two chairs pushed under it and a cabinet that no detector names.
std::vector<Cuboid> Kitchen() {
  std::vector<Cuboid> world = TableAt(0, 0, 0);
  Append(world, ChairAt(1, -0.3, -0.45, -1));
  Append(world, ChairAt(2, 0.3, 0.45, 1));
  world.push_back({3, {1.6, -0.5, 0}, {2.1, 0.5, 0.9}});
  return world;
}

ClassTable Classes() {
  ClassTable table;
  table.classes = {{"chair", {"chair"}, {}, 0.4, 1.5, 0.4, 1.4, {}, {}},
                   {"table", {"dining table"}, {}, 0.4, 4, 0.3, 1.2, {}, {}},
                   {"cabinet", {}, {}, 0.3, 2.6, 0.3, 2.5, {}, {}},
                   {"furniture", {}, {}, 0.2, 3.5, 0.15, 2.7, {}, {.fallback = true}}};
  return table;
}

std::vector<Pose3> Walk() { return Orbit({0.6, 0, 0.4}, 3.0, 1.6, 0, 15, 24); }

CoarseSurface Fuse(const BoxWorldSource& source) {
  fuse::CoarseFusion fusion({});
  for (int f = 0; f < source.num_frames(); ++f) {
    EXPECT_TRUE(fusion
                    .Integrate(source.View({f}).frame,
                               source.camera(),
                               *source.capture_world_from_camera({f}))
                    .ok());
  }
  CoarseSurface surface = std::move(fusion).Take();
  surface.has_ground = true;
  return surface;
}

// True boxes with masks of the first objects, of these classes.
std::vector<Detection> Detect(const BoxWorldSource& source, const std::vector<std::string>& names) {
  std::vector<Detection> detections;
  for (int f = 0; f < source.num_frames(); ++f) {
    const BoxView& view = source.View({f});
    for (int object = 0; object < static_cast<int>(names.size()); ++object) {
      auto detection = DetectTruth(view, object, names[static_cast<std::size_t>(object)]);
      if (!detection) continue;
      Mask mask(view.object.width(), view.object.height());
      for (std::size_t p = 0; p < mask.size(); ++p)
        mask.data()[p] = view.object.data()[p] == object ? 1 : 0;
      detection->mask = mask;
      detection->id = {static_cast<int>(detections.size())};
      detections.push_back(*std::move(detection));
    }
  }
  return detections;
}

class CountingProgress final : public Progress {
 public:
  void Report(std::size_t, std::size_t) override {}
  void Warn(std::string_view message) override { warnings.emplace_back(message); }
  [[nodiscard]] bool StopRequested() const override { return stop; }

  std::vector<std::string> warnings;
  bool stop = false;
};

class FindThingsTest : public testing::Test {
 protected:
  FindThingsTest()
      : source_(Kitchen(), Walk()),
        surface_(Fuse(source_)),
        detections_(Detect(source_, {"table", "chair", "chair"})),
        odometry_(source_.TrueOdometry()) {
    for (int f = 0; f < source_.num_frames(); ++f) looked_at_.push_back({f});
    wanted_ = looked_at_;
  }

  Result<FoundThings> Find() {
    const ThingInputs inputs{source_,
                             odometry_,
                             surface_,
                             layout_,
                             classes_,
                             wanted_,
                             looked_at_,
                             detections_,
                             static_cast<int>(detections_.size())};
    options_.silhouettes.min_points = 150;
    return FindThings(inputs, options_, progress_);
  }

  BoxWorldSource source_;
  CoarseSurface surface_;
  Layout layout_;
  ClassTable classes_ = Classes();
  std::vector<Detection> detections_;
  Odometry odometry_;
  std::vector<FrameIdx> wanted_;
  std::vector<FrameIdx> looked_at_;
  CountingProgress progress_;
  ThingOptions options_;
};

TEST_F(FindThingsTest, EveryThingIsATrackOfItsOwn) {
  const Result<FoundThings> found = Find();
  ASSERT_TRUE(found.ok()) << found.error().message;
  std::multiset<std::string> classes;
  for (const ObjectTrack& track : found->association.tracks) classes.insert(track.class_name);
  EXPECT_THAT(classes, ElementsAre("cabinet", "chair", "chair", "table"));
}

TEST_F(FindThingsTest, MembersNameSegmentsAndEachDetectionIsUsedOnce) {
  const Result<FoundThings> found = Find();
  ASSERT_TRUE(found.ok());
  std::map<DetectionId, FrameIdx> frames;
  for (const Segment& segment : found->segments)
    EXPECT_TRUE(frames.emplace(segment.detection, segment.frame).second);
  std::set<DetectionId> named;
  for (const ObjectTrack& track : found->association.tracks) {
    EXPECT_TRUE(std::ranges::is_sorted(track.members, {}, &TrackMember::frame));
    for (const TrackMember& member : track.members) {
      EXPECT_EQ(frames.at(member.detection), member.frame);
      EXPECT_TRUE(named.insert(member.detection).second);
    }
  }
  for (const Rejection& rejection : found->association.rejections)
    EXPECT_TRUE(named.insert(rejection.detection).second);
  for (const Detection& detection : detections_) EXPECT_TRUE(named.contains(detection.id));
}

// What detectors call a thing is counted; what clusters guess by size is no vote.
TEST_F(FindThingsTest, VotesAreThoseOfDetectors) {
  Detection guess = detections_.front();
  ASSERT_EQ(guess.class_name, "table");
  guess.class_name = "cabinet";
  guess.source = DetectionSource::kCluster;
  guess.id = {static_cast<int>(detections_.size())};
  detections_.insert(detections_.begin(), guess);
  const Result<FoundThings> found = Find();
  ASSERT_TRUE(found.ok());
  for (const ObjectTrack& track : found->association.tracks) {
    if (track.class_name == "cabinet") {
      EXPECT_THAT(track.class_votes, IsEmpty());
      EXPECT_FALSE(track.is_named());
      continue;
    }
    EXPECT_TRUE(track.is_named());
    EXPECT_THAT(track.class_votes, SizeIs(1));
    EXPECT_GT(track.class_votes.at(track.class_name), 1);
  }
}

TEST_F(FindThingsTest, DoesNotDependOnTheNumberOfThreads) {
  const auto summary = [&](int num_threads) {
    const ThreadLimit limit(num_threads);
    const Result<FoundThings> found = Find();
    EXPECT_TRUE(found.ok());
    std::vector<std::string> lines;
    for (const Segment& segment : found->segments)
      lines.push_back(std::to_string(segment.detection.value) + segment.mask.rle());
    return lines;
  };
  EXPECT_EQ(summary(1), summary(2));
}

TEST_F(FindThingsTest, AFrameThatCannotBeReadIsWarnedAboutOnceAndLeftOut) {
  source_.broken.insert(3);
  const Result<FoundThings> found = Find();
  ASSERT_TRUE(found.ok());
  EXPECT_THAT(progress_.warnings, ElementsAre(HasSubstr("broken")));
  EXPECT_THAT(found->association.tracks, SizeIs(4));
  for (const Segment& segment : found->segments) EXPECT_NE(segment.frame.value, 3);
}

TEST_F(FindThingsTest, StopsWhenAskedTo) {
  progress_.stop = true;
  const Result<FoundThings> found = Find();
  ASSERT_FALSE(found.ok());
  EXPECT_EQ(found.error().code, ErrorCode::kInterrupted);
}

// The cabinet, too small to be mapped now, is shown where the truth has it.
TEST_F(FindThingsTest, WhatIsNotMappedIsShownInTheFrameThatShowsMostOfIt) {
  constexpr int kCabinet = 3;
  options_.instances.min_unnamed_size_m = 2;
  const Result<FoundThings> found = Find();
  ASSERT_TRUE(found.ok());
  const auto cabinet = std::ranges::find_if(found->association.not_mapped, [](const NotMapped& n) {
    return n.what.starts_with("cabinet at 1.8");
  });
  ASSERT_NE(cabinet, found->association.not_mapped.end());
  const SeenIn& best = cabinet->best;
  const auto area_px = [&](FrameIdx frame) {
    return std::ranges::count(source_.View(frame).object, kCabinet);
  };
  const auto most = *std::ranges::max_element(looked_at_, {}, area_px);
  ASSERT_GE(best.frame.value, 0);
  EXPECT_GT(static_cast<double>(area_px(best.frame)), 0.7 * static_cast<double>(area_px(most)));
  const auto truth = DetectTruth(source_.View(best.frame), kCabinet, "cabinet");
  ASSERT_TRUE(truth);
  EXPECT_GT(IntersectionOverUnion(best.box_px, truth->box_px), 0.7);
}

TEST_F(FindThingsTest, FramesThatNoDetectorLookedAtShowThingsAndHaveNoSayInTheirClasses) {
  const Result<FoundThings> by_all = Find();
  ASSERT_TRUE(by_all.ok());
  std::erase_if(looked_at_, [](FrameIdx frame) { return frame.value % 3 != 0; });
  std::erase_if(detections_, [](const Detection& d) { return d.frame.value % 3 != 0; });
  const Result<FoundThings> by_some = Find();
  ASSERT_TRUE(by_some.ok());
  const auto names = [](const FoundThings& found) {
    std::vector<std::string> of_tracks;
    for (const ObjectTrack& track : found.association.tracks) of_tracks.push_back(track.class_name);
    return of_tracks;
  };
  EXPECT_EQ(names(*by_some), names(*by_all));
  EXPECT_GT(by_some->segments.size(), by_all->segments.size() * 9 / 10);
}

// Whether the cabinet is mapped by so many frames of a camera that looks at a point.
class FewViews {
 public:
  FewViews(const Eigen::Vector3d& target_m, int num_frames)
      : source_(Kitchen(), Orbit(target_m, 2.2, 1.6, 150, 8, num_frames)),
        odometry_(source_.TrueOdometry()) {
    for (int f = 0; f < num_frames; ++f) looked_at_.push_back({f});
  }
  [[nodiscard]] bool IsCut() const {
    return std::ranges::all_of(looked_at_, [&](FrameIdx frame) {
      const auto truth = DetectTruth(source_.View(frame), 3, "cabinet");
      return truth && truth->box_px.v_max >= source_.camera().height - 2;
    });
  }
  [[nodiscard]] bool IsMapped(const CoarseSurface& surface) const {
    const Layout layout;
    const ClassTable classes = Classes();
    CountingProgress progress;
    const Result<FoundThings> found =
        FindThings({source_, odometry_, surface, layout, classes, looked_at_, looked_at_, {}, 0},
                   {},
                   progress);
    return found.ok() && std::ranges::any_of(found->association.tracks, [](const ObjectTrack& t) {
             return t.class_name == "cabinet";
           });
  }

 private:
  BoxWorldSource source_;
  Odometry odometry_;
  std::vector<FrameIdx> looked_at_;
};

TEST_F(FindThingsTest, WhatNothingNamesNeedsFourViewsOrTwiceAsManyThatCutIt) {
  const Eigen::Vector3d at_it(1.85, 0, 0.45);
  EXPECT_FALSE(FewViews(at_it, 3).IsMapped(surface_));
  EXPECT_FALSE(FewViews(at_it, 4).IsCut());
  EXPECT_TRUE(FewViews(at_it, 4).IsMapped(surface_));
  const Eigen::Vector3d above_it(1.85, 0, 1.5);
  ASSERT_TRUE(FewViews(above_it, 8).IsCut());
  EXPECT_FALSE(FewViews(above_it, 7).IsMapped(surface_));
  EXPECT_TRUE(FewViews(above_it, 8).IsMapped(surface_));
}

TEST_F(FindThingsTest, WithoutFramesOrSurfaceThereIsNothing) {
  wanted_.clear();
  looked_at_.clear();
  detections_.clear();
  Result<FoundThings> found = Find();
  ASSERT_TRUE(found.ok());
  EXPECT_THAT(found->association.tracks, IsEmpty());
  ASSERT_THAT(found->association.not_mapped,
              testing::Not(IsEmpty()));  // the cabinet, which no frame shows
  EXPECT_LT(found->association.not_mapped[0].best.frame.value, 0);
  surface_ = {};
  surface_.voxel_m = 0.04;
  found = Find();
  ASSERT_TRUE(found.ok());
  EXPECT_THAT(found->association.tracks, IsEmpty());
}

// Pixels of a block's silhouettes over all frames. The frames show a rail above it that its
// detections hold and the surface of the capture does not.
std::size_t CountPixelsUnderARail(const ClassTraits& traits) {
  std::vector<Cuboid> world = {{0, {-0.3, -0.3, 0}, {0.3, 0.3, 0.5}}};
  const CoarseSurface surface = Fuse(BoxWorldSource(world, Walk()));
  world.push_back({0, {-0.3, 0.27, 0.8}, {0.3, 0.3, 0.9}});
  const BoxWorldSource source(world, Walk());
  ClassTable classes = Classes();
  classes.classes[0].traits = traits;
  const std::vector<Detection> detections = Detect(source, {"chair"});
  std::vector<FrameIdx> looked_at;
  for (int f = 0; f < source.num_frames(); ++f) looked_at.push_back({f});
  ThingOptions options;
  options.silhouettes.min_points = 150;
  CountingProgress progress;
  const Odometry odometry = source.TrueOdometry();
  const Layout layout;
  const Result<FoundThings> found = FindThings({source,
                                                odometry,
                                                surface,
                                                layout,
                                                classes,
                                                looked_at,
                                                looked_at,
                                                detections,
                                                static_cast<int>(detections.size())},
                                               options,
                                               progress);
  EXPECT_TRUE(found.ok());
  std::size_t count = 0;
  for (const Segment& segment : found->segments)
    count += static_cast<std::size_t>(segment.num_points);
  return count;
}

TEST(FindThings, SlimPartsThatMasksShowAreOfOpenThingsAlone) {
  const std::size_t closed = CountPixelsUnderARail({.solid_inside = true});
  EXPECT_GT(closed, 10000U);
  EXPECT_GT(CountPixelsUnderARail({}), closed + 1000);
}

}  // namespace
}  // namespace deepslam::discovery
