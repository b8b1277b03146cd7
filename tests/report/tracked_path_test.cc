#include "deepslam/report/tracked_path.h"

#include <gmock/gmock.h>

#include "deepslam/report/warnings.h"

namespace deepslam::report {
namespace {

using testing::IsEmpty;

Trajectory ThreeFrames() {
  Trajectory trajectory;
  trajectory.frames.resize(3);
  for (int n = 0; n < 3; ++n) {
    auto& frame = trajectory.frames[static_cast<std::size_t>(n)];
    frame.frame = FrameIdx{n};
    frame.world_from_camera.translation_m = {0.1 * n, 0, 0};
    frame.world_from_camera.rotation = Eigen::AngleAxisd(0.2 * n, Eigen::Vector3d::UnitY());
  }
  return trajectory;
}

// The tracked path moved as a whole into the final world.
OptimizedMap Moved(const Trajectory& tracked, const Pose3& final_from_tracked) {
  OptimizedMap map;
  map.has_ground = true;
  map.frames = tracked.frames;
  for (TrackedFrame& frame : map.frames)
    frame.world_from_camera = final_from_tracked * frame.world_from_camera;
  return map;
}

const Pose3 kFinalFromTracked{
    Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized())), {1, 2, 1.4}};

TEST(LayOntoMap, AMereChangeOfWorldLeavesNoDifference) {
  const Trajectory tracked = ThreeFrames();
  const OptimizedMap map = Moved(tracked, kFinalFromTracked);
  Ground ground;
  ground.observations.resize(2);
  ground.observations[0].keyframe = FrameIdx{1};
  ground.observations[0].plane_camera.d_m = 1.3;
  ground.observations[1].keyframe = FrameIdx{7};  // of no frame
  const TrackedPath path = LayOntoMap(tracked, ground, map);
  ASSERT_EQ(path.world_from_camera.size(), 3U);
  for (std::size_t n = 0; n < 3; ++n) {
    const Pose3 difference = path.world_from_camera[n].Inverse() * map.frames[n].world_from_camera;
    EXPECT_LT(difference.translation_m.norm(), 1e-12);
    EXPECT_LT(difference.rotation.angularDistance(Eigen::Quaterniond::Identity()), 1e-7);
  }
  ASSERT_EQ(path.heights.size(), 1U);
  EXPECT_EQ(path.heights[0].frame, FrameIdx{1});
  EXPECT_EQ(path.heights[0].measured_m, 1.3);
  EXPECT_NEAR(path.heights[0].before_m, path.heights[0].after_m, 1e-12);
}

TEST(LayOntoMap, SaysNothingWithoutAGroundOrOfAnotherPath) {
  const Trajectory tracked = ThreeFrames();
  OptimizedMap map = Moved(tracked, kFinalFromTracked);
  map.has_ground = false;
  Ground ground;
  ground.observations.resize(1);
  ground.observations[0].keyframe = FrameIdx{1};
  EXPECT_THAT(LayOntoMap(tracked, ground, map).heights, IsEmpty());
  map.frames.pop_back();
  EXPECT_THAT(LayOntoMap(tracked, ground, map).world_from_camera, IsEmpty());
  EXPECT_THAT(LayOntoMap({}, ground, {}).world_from_camera, IsEmpty());
}

TEST(Warnings, CountDetectionsWithoutAnObjectByReason) {
  Association association;
  association.rejections = {{DetectionId{1}, FrameIdx{0}, "too small"},
                            {DetectionId{2}, FrameIdx{0}, "cut off"},
                            {DetectionId{3}, FrameIdx{1}, "too small"}};
  Proposals proposals;
  proposals.notes = {"no prior"};
  ObjectMap map;
  map.dropped = {"object 4 fits nowhere"};
  const std::vector<std::string> capture = {"no times"};
  EXPECT_THAT(Warnings(capture, association, proposals, map),
              testing::ElementsAre("no times",
                                   "no prior",
                                   "object 4 fits nowhere",
                                   "1 detection belongs to no object: cut off",
                                   "2 detections belong to no object: too small"));
  EXPECT_THAT(Warnings({}, {}, {}, {}), IsEmpty());
}

}  // namespace
}  // namespace deepslam::report
