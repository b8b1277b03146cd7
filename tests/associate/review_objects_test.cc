#include "deepslam/associate/review_objects.h"

#include <gmock/gmock.h>

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
    observation.cloud_world = PointCloud(Seat(k < 2 ? 0 : 0.08));
    objects[object].id = ObjectId(static_cast<int>(object));
    TrackMember member;
    member.detection = observation.segment->detection;
    member.frame = observation.segment->frame;
    AddMember(objects[object], all, k, member, kCell_m);
  }
  std::vector<Rejection> rejections;
  MergeDuplicates(objects, all, {}, rejections);
  EXPECT_THAT(rejections, SizeIs(2 - objects.size()));  // of two detections in a frame, one stays
  return objects.size();
}

TEST(MajorityClass, WhatIsRecognisedOutvotesGuessesBySize) {
  std::vector<Segment> segments(8, Chair(0, 1, {0, 0, 10, 10}));
  std::vector<Observation> all(segments.size());
  ObjectHypothesis object;
  for (std::size_t k = 0; k < segments.size(); ++k) {
    all[k].segment = &segments[k];
    object.observations.push_back(static_cast<int>(k));
    if (k < 2) continue;
    segments[k].class_name = "cabinet";
    segments[k].source = DetectionSource::kCluster;
  }
  EXPECT_EQ(MajorityClass(object, all), "chair") << "2 of a network against 6 by size";
  object.observations.erase(object.observations.begin(), object.observations.begin() + 2);
  EXPECT_EQ(MajorityClass(object, all), "cabinet");
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
