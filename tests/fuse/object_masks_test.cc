#include "deepslam/fuse/object_masks.h"

#include <gmock/gmock.h>

namespace deepslam::fuse {
namespace {

using testing::ElementsAre;

Mask OnePixel(int u, int v, int width = 4, int height = 3) {
  Mask mask(width, height);
  mask(u, v) = 1;
  return mask;
}

Segment SegmentOf(FrameIdx frame, const Mask& mask) {
  Segment segment;
  segment.frame = frame;
  segment.mask = PixelMask(mask);
  return segment;
}

TrackMember MemberOf(DetectionId detection) {
  TrackMember member;
  member.detection = detection;
  return member;
}

TEST(DetectionsOfMap, AreThoseOfObjectsInTheMap) {
  Association association;
  association.tracks.resize(2);
  association.tracks[0].id = ObjectId{1};
  association.tracks[0].members = {MemberOf(DetectionId{10}), MemberOf(DetectionId{12})};
  association.tracks[1].id = ObjectId{2};
  association.tracks[1].members = {MemberOf(DetectionId{11})};
  OptimizedMap map;
  map.map.objects.resize(1);
  map.map.objects[0].id = ObjectId{1};
  EXPECT_THAT(DetectionsOfMap(map, association), ElementsAre(DetectionId{10}, DetectionId{12}));
  EXPECT_TRUE(DetectionsOfMap({}, association).empty());
}

TEST(ObjectPixels, AreThoseOfAllObjectsOfTheFrame) {
  const std::vector<FrameIdx> looked_at = {FrameIdx{0}, FrameIdx{5}};
  const std::vector<Segment> segments = {SegmentOf(FrameIdx{0}, OnePixel(1, 1)),
                                         SegmentOf(FrameIdx{0}, OnePixel(3, 2)),
                                         SegmentOf(FrameIdx{7}, OnePixel(0, 0))};
  const ObjectMasks masks = MasksByFrame(looked_at, looked_at, segments);
  const Mask both = ObjectPixels(masks, FrameIdx{0});
  for (int v = 0; v < 3; ++v) {
    for (int u = 0; u < 4; ++u)
      EXPECT_EQ(both(u, v), (u == 1 && v == 1) || (u == 3 && v == 2) ? 1 : 0);
  }
  EXPECT_EQ(ObjectPixels(masks, FrameIdx{7}), OnePixel(0, 0));
  EXPECT_TRUE(ObjectPixels(masks, FrameIdx{5}).empty());  // looked at, nothing found
  EXPECT_TRUE(ObjectPixels(masks, FrameIdx{6}).empty());  // not looked at
}

TEST(ObjectPixels, AMaskOfAnotherSizeCountsForNothing) {
  const std::vector<Segment> segments = {SegmentOf(FrameIdx{0}, OnePixel(1, 1)),
                                         SegmentOf(FrameIdx{0}, OnePixel(0, 0, 9, 9))};
  EXPECT_EQ(ObjectPixels(MasksByFrame({}, {}, segments), FrameIdx{0}), OnePixel(1, 1));
}

TEST(FramesWithMasks, AreTheAlignedKeyframesThatWereLookedAtAndThoseWithObjects) {
  std::vector<TrackedFrame> frames(6);
  for (int n = 0; n < 6; ++n) frames[static_cast<std::size_t>(n)].frame = FrameIdx{n};
  frames[1].status = TrackingStatus::kLost;
  const std::vector<FrameIdx> looked_at = {FrameIdx{0}, FrameIdx{1}, FrameIdx{3}, FrameIdx{5}};
  const std::vector<FrameIdx> keyframes = {FrameIdx{0}, FrameIdx{1}, FrameIdx{2}, FrameIdx{3}};
  const std::vector<Segment> segments = {SegmentOf(FrameIdx{4}, OnePixel(1, 1))};
  const ObjectMasks masks = MasksByFrame(looked_at, keyframes, segments);
  EXPECT_THAT(FramesWithMasks(frames, masks), ElementsAre(FrameIdx{0}, FrameIdx{3}, FrameIdx{4}));
}

}  // namespace
}  // namespace deepslam::fuse
