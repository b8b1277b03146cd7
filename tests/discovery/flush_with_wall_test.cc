#include "deepslam/discovery/flush_with_wall.h"

#include <gmock/gmock.h>

#include "support/box_world.h"

namespace deepslam::discovery {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using namespace testing_support;  // NOLINT

constexpr double kWall_m = 2.0;  // y of its face

// A wall with something 8 cm thick on it (0), a poster (1), and a chest before it (2).
std::vector<Cuboid> Room() {
  return {{-1, {-3, kWall_m, 0}, {3, kWall_m + 0.2, 2.5}},
          {0, {-0.4, kWall_m - 0.08, 1.2}, {0.4, kWall_m, 1.7}},
          {1, {1.0, kWall_m - 0.003, 1.2}, {1.6, kWall_m, 1.7}},
          {2, {-1.6, kWall_m - 0.4, 0}, {-0.9, kWall_m, 0.5}}};
}

Layout WallOnly() {
  Layout layout;
  LayoutWall wall;
  wall.from_m = {3, kWall_m};
  wall.to_m = {-3, kWall_m};
  wall.top_m = 2.5;
  layout.walls.push_back(wall);
  return layout;
}

ClassTable Classes() {
  ClassTable table;
  table.classes.resize(2);
  table.classes[0].name = "tv";
  table.classes[0].traits.supports = {.floor = false, .furniture = true, .wall = true};
  table.classes[1].name = "cabinet";
  return table;
}

class OnAWall : public testing::Test {
 protected:
  // The tracks of all things, each of a class.
  Association Tracks(const std::vector<std::string>& class_names) {
    Association association;
    segments_.clear();
    for (std::size_t n = 0; n < class_names.size(); ++n) {
      ObjectTrack track;
      track.id = ObjectId{static_cast<int>(n)};
      track.class_name = class_names[n];
      for (int f = 0; f < source_.num_frames(); ++f) {
        const Image<int>& object = source_.View({f}).object;
        Mask mask(object.width(), object.height());
        for (int v = 0; v < object.height(); ++v) {
          for (int u = 0; u < object.width(); ++u)
            mask(u, v) = object(u, v) == static_cast<int>(n) ? 1 : 0;
        }
        Segment segment;
        segment.detection = DetectionId{10 * f + static_cast<int>(n)};
        segment.frame = FrameIdx{f};
        segment.box_px = {0, 0, 10.0 + f, 10};
        segment.mask = PixelMask(mask);
        segments_.push_back(segment);
        TrackMember member;
        member.detection = segment.detection;
        member.frame = segment.frame;
        track.members.push_back(member);
      }
      association.tracks.push_back(track);
    }
    return association;
  }

  Association Left(Association association, const Layout& layout) {
    const Odometry odometry = source_.TrueOdometry();
    LeaveOutFlush({source_, odometry, layout, Classes(), segments_}, association);
    return association;
  }

  static std::vector<int> Ids(const Association& association) {
    std::vector<int> ids;
    for (const ObjectTrack& track : association.tracks) ids.push_back(track.id.value);
    return ids;
  }

  BoxWorldSource source_{Room(),
                         {LookAt({0.3, -0.4, 1.4}, {0.3, kWall_m, 1.2}),
                          LookAt({0.0, -0.2, 1.4}, {0.0, kWall_m, 1.2})}};
  std::vector<Segment> segments_;
};

TEST_F(OnAWall, APosterIsNoThingAndWhatStandsOutIs) {
  const Association left = Left(Tracks({"tv", "tv", "cabinet"}), WallOnly());
  EXPECT_THAT(Ids(left), ElementsAre(0, 2));
  EXPECT_THAT(left.rejections, SizeIs(2));
  ASSERT_THAT(left.not_mapped, SizeIs(1));
  EXPECT_THAT(left.not_mapped[0].what, HasSubstr("flush in a wall"));
  EXPECT_EQ(left.not_mapped[0].best.frame.value, 1) << "its box is larger there";
}

TEST_F(OnAWall, WhatStandsOnTheFloorIsLeftAlone) {
  EXPECT_THAT(Ids(Left(Tracks({"tv", "cabinet", "cabinet"}), WallOnly())), ElementsAre(0, 1, 2));
}

TEST_F(OnAWall, WithoutWallsOrFramesNothingIsSaid) {
  EXPECT_THAT(Ids(Left(Tracks({"tv", "tv"}), Layout())), ElementsAre(0, 1));
  source_.broken = {0, 1};
  EXPECT_THAT(Ids(Left(Tracks({"tv", "tv"}), WallOnly())), ElementsAre(0, 1));
  EXPECT_THAT(Ids(Left({}, WallOnly())), IsEmpty());
}

}  // namespace
}  // namespace deepslam::discovery
