#include "deepslam/fuse/fuse_frames.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deepslam/dataset/memory_frame_source.h"
#include "support/recording_progress.h"

namespace deepslam::fuse {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing_support::RecordingProgress;

const PinholeCamera kCamera{80, 60, 75, 75, 39.5, 29.5};
constexpr float kWallM = 2.0F;
constexpr float kThingM = 1.0F;

// Of the left half of the images: a thing stands there, before a wall.
PixelMask LeftHalf() {
  Mask mask(kCamera.width, kCamera.height);
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 0; u < kCamera.width / 2; ++u) mask(u, v) = 1;
  }
  return PixelMask(mask);
}

// Cameras that look along z and move along x.
struct Walk {
  std::vector<Frame> frames;
  std::vector<TrackedFrame> path;
};

Walk Look(int num_frames) {
  const Mask thing = LeftHalf().Unpacked();
  Walk walk;
  for (int k = 0; k < num_frames; ++k) {
    Frame frame;
    frame.colour = ColourImage(kCamera.width, kCamera.height, {200, 100, 50});
    frame.depth_m = DepthImage(kCamera.width, kCamera.height, kWallM);
    std::transform(thing.begin(), thing.end(), frame.depth_m.begin(), [](std::uint8_t is_thing) {
      return is_thing != 0 ? kThingM : kWallM;
    });
    walk.frames.push_back(std::move(frame));
    TrackedFrame tracked;
    tracked.frame = FrameIdx{k};
    tracked.world_from_camera.translation_m.x() = 0.002 * k;
    walk.path.push_back(tracked);
  }
  return walk;
}

FuseOptions Coarse() {
  FuseOptions options;
  options.voxel_m = 0.03;
  options.truncation_m = 0.09;
  options.min_component_faces = 0;
  return options;
}

std::vector<FrameIdx> All(const Walk& walk) {
  std::vector<FrameIdx> frames;
  for (const TrackedFrame& frame : walk.path) frames.push_back(frame.frame);
  return frames;
}

bool HasSurfaceAt(const TriangleMesh& mesh, float z_m) {
  return std::ranges::any_of(
      mesh.vertices, [&](const Eigen::Vector3f& p) { return std::abs(p.z() - z_m) < 0.03F; });
}

TEST(FuseFrames, GivesTheSurfaceWithOrWithoutObjects) {
  const Walk walk = Look(3);
  const dataset::MemoryFrameSource source(kCamera, walk.frames);
  RecordingProgress progress;
  const ObjectMasks none;
  const auto whole = FuseFrames({source, walk.path, none}, All(walk), Coarse(), progress);
  ASSERT_TRUE(whole.ok());
  EXPECT_TRUE(HasSurfaceAt(*whole, kWallM));
  EXPECT_TRUE(HasSurfaceAt(*whole, kThingM));
  ObjectMasks things;
  for (const FrameIdx frame : All(walk)) things[frame] = {LeftHalf()};
  const auto without = FuseFrames({source, walk.path, things}, All(walk), Coarse(), progress);
  ASSERT_TRUE(without.ok());
  EXPECT_TRUE(HasSurfaceAt(*without, kWallM));
  EXPECT_FALSE(HasSurfaceAt(*without, kThingM));
}

TEST(FuseFrames, AFrameThatCannotBeReadIsToldAndTheOthersAreFused) {
  Walk walk = Look(3);
  walk.frames[1] = Frame();
  const dataset::MemoryFrameSource source(kCamera, walk.frames);
  RecordingProgress progress;
  const ObjectMasks none;
  const auto surface = FuseFrames({source, walk.path, none}, All(walk), Coarse(), progress);
  ASSERT_TRUE(surface.ok());
  EXPECT_TRUE(HasSurfaceAt(*surface, kWallM));
  EXPECT_THAT(progress.warnings, ElementsAre(HasSubstr("frame 1 skipped")));
}

TEST(FuseFrames, MasksOfAnotherSizeAreRefused) {
  const Walk walk = Look(1);
  const dataset::MemoryFrameSource source(kCamera, walk.frames);
  RecordingProgress progress;
  const ObjectMasks other{{FrameIdx{0}, {PixelMask(Mask(4, 3, 1))}}};
  const auto surface = FuseFrames({source, walk.path, other}, All(walk), Coarse(), progress);
  ASSERT_FALSE(surface.ok());
  EXPECT_EQ(surface.error().code, ErrorCode::kInvalidInput);
}

TEST(FuseFrames, EndsWhenAskedTo) {
  const Walk walk = Look(3);
  const dataset::MemoryFrameSource source(kCamera, walk.frames);
  RecordingProgress progress(2);
  const ObjectMasks none;
  const auto surface = FuseFrames({source, walk.path, none}, All(walk), Coarse(), progress);
  ASSERT_FALSE(surface.ok());
  EXPECT_EQ(surface.error().code, ErrorCode::kInterrupted);
}

}  // namespace
}  // namespace deepslam::fuse
