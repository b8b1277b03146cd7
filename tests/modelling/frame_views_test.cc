#include "deepslam/modelling/frame_views.h"

#include <optional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "modelling/furnished_room.h"

namespace deepslam::modelling {
namespace {

using ::deepslam::testing_support::ChairGrid;
using ::testing::ElementsAre;
using ::testing::SizeIs;
using testing_support::Frames;
using testing_support::Furniture;
using testing_support::ModelledRoom;

const Furniture kChair = {"chair", ChairGrid(), 0.9, 0.0, -0.3, 0.4};
const Furniture kOther = {"chair", ChairGrid(), 0.9, -0.5, 0.8, 2.2};

class FrameViewsTest : public testing::Test {
 protected:
  FrameViewsTest() {
    room_.Track(3, 0, Frames(0, 3));
    room_.Track(4, 0, {});
    room_.Track(7, 1, Frames(1, 2));
  }

  // "3:3 4:0 | 7:2": object and number of views, batches apart.
  [[nodiscard]] std::string Batches(std::size_t batch_bytes) {
    const FrameViews views(
        {room_.room, room_.segments, room_.classes}, {}, room_.progress, batch_bytes);
    std::string batches;
    const Status status = views.ForBatches(
        room_.Objects(), observe::ViewContent::kDepth, [&](std::span<TrackViews> batch) {
          if (!batches.empty()) batches += "| ";
          for (const TrackViews& of_track : batch) {
            batches += std::to_string(of_track.track->id.value) + ":" +
                       std::to_string(of_track.views.size()) + " ";
          }
          return Ok();
        });
    EXPECT_TRUE(status.ok());
    return batches;
  }

  ModelledRoom room_{{kChair, kOther}};
};

TEST_F(FrameViewsTest, EveryTrackComesOnceAndInOrderWhateverTheBatch) {
  EXPECT_EQ(Batches(FrameViews::kBatchBytes), "3:3 4:0 7:2 ");
  EXPECT_EQ(Batches(1), "3:3 | 4:0 7:2 ");
  EXPECT_EQ(Batches(0), "3:3 | 4:0 | 7:2 ");
}

TEST_F(FrameViewsTest, ViewsShowTheObjectFromWhereTheCameraWas) {
  const FrameViews views = room_.Views();
  const auto check = [&](std::span<TrackViews> batch) {
    const std::vector<ObjectView>& of_chair = batch[0].views;
    EXPECT_THAT(of_chair, SizeIs(3));
    for (const ObjectView& view : of_chair) {
      EXPECT_EQ(view.world_from_camera, room_.room.odometry.at(view.frame).world_from_camera);
      EXPECT_TRUE(view.colour_crop.empty());
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      int count = 0;
      for (int v = 0; v < view.mask_crop.height(); ++v) {
        for (int u = 0; u < view.mask_crop.width(); ++u) {
          if (view.mask_crop(u, v) == 0) continue;
          sum += view.world_from_camera * view.camera.Unproject(u, v, view.depth_crop_m(u, v));
          ++count;
        }
      }
      EXPECT_GT(count, 100);
      EXPECT_LT((sum / count - room_.room.truth(0).translation_m).norm(), 0.4);
    }
    return Ok();
  };
  EXPECT_TRUE(views.ForBatches(room_.Objects(), observe::ViewContent::kDepth, check).ok());
}

TEST_F(FrameViewsTest, ASegmentThatNoTrackKnowsAndATrackThatNoSegmentKnowsAreNoViews) {
  room_.segments->segments.push_back(room_.room.SegmentOf(1, FrameIdx{7}));
  room_.association.tracks[0].members.push_back({DetectionId{99999}, FrameIdx{5}, 0, 0, "vote"});
  EXPECT_EQ(Batches(FrameViews::kBatchBytes), "3:3 4:0 7:2 ");
}

// For whoever registers and scores it, a thing that rests on furniture stands on what it rests on.
TEST_F(FrameViewsTest, TheGroundOfAThingOffTheFloorIsWhatItRestsOn) {
  const auto ground_of_first = [&] {
    std::optional<Plane> ground;
    const auto take = [&](std::span<TrackViews> batch) {
      if (!ground) ground = batch[0].views[0].ground_camera;
      return Ok();
    };
    EXPECT_TRUE(room_.Views().ForBatches(room_.Objects(), observe::ViewContent::kDepth, take).ok());
    return ground;
  };
  const std::optional<Plane> floor = ground_of_first();
  ASSERT_TRUE(floor.has_value());
  room_.classes.classes = {
      {"chair", {}, {}, 0.1, 3, 0.1, 3, {}, {.supports = {.floor = false, .furniture = true}}}};
  const std::optional<Plane> own = ground_of_first();
  ASSERT_TRUE(own.has_value());
  EXPECT_EQ(own->normal, floor->normal);
  EXPECT_LT(own->d_m, floor->d_m) << "its lowest points lie above the floor";
}

TEST_F(FrameViewsTest, TheFirstErrorEndsIt) {
  const FrameViews views({room_.room, room_.segments, room_.classes}, {}, room_.progress, 0);
  int num_batches = 0;
  const Status status = views.ForBatches(
      room_.Objects(), observe::ViewContent::kDepth, [&](std::span<TrackViews>) -> Status {
        ++num_batches;
        return Failed("enough");
      });
  EXPECT_EQ(status.error().message, "enough");
  EXPECT_EQ(num_batches, 1);
}

class FaultyStore final : public SegmentStore {
 public:
  [[nodiscard]] std::span<const Segment> without_masks() const override { return {}; }
  [[nodiscard]] Result<std::vector<Segment>> Of(const std::set<DetectionId>&) const override {
    return Failed("the disk is full");
  }
};

TEST_F(FrameViewsTest, TheErrorOfTheStoreIsPassedOn) {
  const FrameViews views(
      {room_.room, std::make_shared<FaultyStore>(), room_.classes}, {}, room_.progress);
  const Status status = views.ForBatches(
      room_.Objects(), observe::ViewContent::kDepth, [](std::span<TrackViews>) { return Ok(); });
  EXPECT_EQ(status.error().message, "the disk is full");
}

TEST(ForEachTrack, TakesInOrderAndStopsAtTheFirstError) {
  ModelledRoom room({kChair});
  room.Track(0, 0, Frames(0, 1));
  room.Track(1, 0, Frames(1, 1));
  room.Track(2, 0, Frames(2, 1));
  std::vector<int> taken;
  const PerTrack<int> work{[](const TrackViews& of_track) -> Result<int> {
                             if (of_track.track->id == ObjectId{2}) return Failed("two");
                             return of_track.track->id.value;
                           },
                           [&](const TrackViews&, int id) {
                             taken.push_back(id);
                             return Ok();
                           }};
  const FrameViews views = room.Views();
  const Status status =
      ForEachTrack(views, room.Objects(), observe::ViewContent::kDepth, room.progress, work);
  EXPECT_EQ(status.error().message, "two");
  EXPECT_THAT(taken, ElementsAre(0, 1));
}

}  // namespace
}  // namespace deepslam::modelling
