#include "deepslam/associate/review_objects.h"

#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include <gmock/gmock.h>

#include "deepslam/core/random.h"

namespace deepslam::associate {
namespace {

using testing::SizeIs;

constexpr double kCell_m = 0.02;

// A seat, `off_m` above where it is.
std::vector<Eigen::Vector3f> Seat(double off_m) {
  std::vector<Eigen::Vector3f> points;
  for (int x = 0; x < 20; ++x) {
    for (int y = 0; y < 20; ++y)
      points.emplace_back(0.025F * static_cast<float>(x),
                          0.025F * static_cast<float>(y),
                          static_cast<float>(off_m));
  }
  return points;
}

Segment Chair(int detection, int frame, const Box2& box_px) {
  Segment segment;
  segment.detection = {detection};
  segment.frame = {frame};
  segment.class_name = "chair";
  segment.score = 0.8;
  segment.box_px = box_px;
  segment.num_points = 400;
  segment.usable = true;
  return segment;
}

// How many objects are left of two whose measurements lie 8 cm apart, as drift sets them, with
// these boxes in the frame that shows both.
std::size_t NumLeft(const Box2& first_px, const Box2& second_px) {
  const std::vector<Segment> segments = {
      Chair(0, 1, first_px), Chair(1, 2, first_px), Chair(2, 2, second_px)};
  std::vector<Observation> all(3);
  std::vector<ObjectHypothesis> objects(2);
  for (int k = 0; k < 3; ++k) {
    const std::size_t object = k < 2 ? 0 : 1;
    Observation& observation = all[static_cast<std::size_t>(k)];
    observation.segment = &segments[static_cast<std::size_t>(k)];
    objects[object].id = ObjectId(static_cast<int>(object));
    TrackMember member;
    member.detection = observation.segment->detection;
    member.frame = observation.segment->frame;
    AddMember(objects[object], all, k, member);
    objects[object].points_world.Add(Seat(k < 2 ? 0 : 0.08), kCell_m);
  }
  std::vector<Rejection> rejections;
  MergeDuplicates(objects, all, rejections);
  EXPECT_THAT(rejections, SizeIs(2 - objects.size()));  // of two detections in a frame, one stays
  return objects.size();
}

TEST(GrowingCloud, KeepsTheFirstPointOfEveryCellInTheOrderInWhichTheyCame) {
  Random random(5, "points", 0);
  std::vector<Eigen::Vector3f> all;
  std::vector<Eigen::Vector3f> first;
  std::set<std::array<long, 3>> taken;
  GrowingCloud growing;
  EXPECT_TRUE(growing.points().empty());
  EXPECT_EQ(growing.cloud().Distance(Eigen::Vector3f::Zero(), 1),
            std::numeric_limits<double>::infinity());
  for (int batch = 0; batch < 30; ++batch) {
    std::vector<Eigen::Vector3f> points;
    for (int k = 0; k < 50; ++k) {
      const auto at = [&] { return static_cast<float>(random.Uniform(-0.1, 0.1)); };
      points.emplace_back(at(), at(), at());
      const Eigen::Vector3f& p = points.back();
      if (taken
              .insert({std::lround(p.x() / kCell_m),
                       std::lround(p.y() / kCell_m),
                       std::lround(p.z() / kCell_m)})
              .second)
        first.push_back(p);
    }
    growing.Add(points, kCell_m);
    EXPECT_EQ(growing.points(), first);
    if (batch % 3 == 0) {
      EXPECT_EQ(growing.cloud().points(), first) << "made anew when it is asked for";
    }
    EXPECT_EQ(growing.cloud().Distance(first.back()), 0);
  }
  EXPECT_LT(first.size(), 1500u) << "some share a cell";
}

TEST(ObjectHypothesis, WhatIsRecognisedOutvotesGuessesBySize) {
  std::vector<Segment> segments;
  for (int k = 0; k < 8; ++k) {
    segments.push_back(Chair(k, k, {0, 0, 10, 10}));
    if (k < 2) continue;
    segments.back().class_name = "cabinet";
    segments.back().source = DetectionSource::kCluster;
  }
  std::vector<Observation> all(segments.size());
  ObjectHypothesis object;
  for (const int k : {7, 0, 3, 1, 2, 4, 5, 6}) {
    all[static_cast<std::size_t>(k)].segment = &segments[static_cast<std::size_t>(k)];
    AddMember(object, all, k, {});
  }
  EXPECT_THAT(object.observations, testing::ElementsAre(0, 1, 2, 3, 4, 5, 6, 7)) << "by frames";
  EXPECT_EQ(object.MemberIn(FrameIdx{3}), 3U);
  EXPECT_FALSE(object.MemberIn(FrameIdx{8}));
  EXPECT_EQ(object.class_name, "chair") << "2 of a network against 6 by size";
  RemoveMember(object, all, 1);
  RemoveMember(object, all, 0);
  EXPECT_EQ(object.class_name, "cabinet");
  EXPECT_THAT(object.members, SizeIs(6));
  EXPECT_FALSE(object.MemberIn(FrameIdx{0}));
}

TEST(CoarseViews, OfLongCapturesAnEvenShareIsHeldAndSpeaksForAll) {
  for (const int num_frames : {0, 1, 7, 8, 9, 100, 1000}) {
    CoarseViews views(8);
    for (int k = 0; k < num_frames; ++k) views.Add({k}, Pose3(), DepthImage(16, 16));
    EXPECT_LE(views.num_held(), 8U);
    const double all = views.NumThat([](const CoarseView&) { return true; });
    EXPECT_NEAR(all, num_frames, num_frames <= 8 ? 0 : 0.25 * num_frames);
    const double half =
        views.NumThat([&](const CoarseView& view) { return 2 * view.frame.value < num_frames; });
    EXPECT_NEAR(half, 0.5 * all, 0.13 * all + 0.5);
  }
}

TEST(ReviewObjects, AThingAndHalfOfItInOneFrameAreOneThing) {
  const Box2 whole_px{100, 20, 200, 220}, lower_half_px{101, 120, 200, 221};
  EXPECT_EQ(NumLeft(whole_px, lower_half_px), 1U);
  EXPECT_EQ(NumLeft(lower_half_px, whole_px), 1U);
}

TEST(ReviewObjects, ThingsSideBySideInOneFrameAreTwo) {
  const Box2 left_px{100, 20, 200, 220}, right_px{150, 20, 250, 220};
  EXPECT_EQ(NumLeft(left_px, right_px), 2U);
}

}  // namespace
}  // namespace deepslam::associate
