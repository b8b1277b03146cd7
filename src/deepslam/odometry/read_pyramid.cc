#include "deepslam/odometry/read_pyramid.h"

#include <utility>

namespace deepslam::odometry {

Result<ReadFrame> ReadPyramid(const FrameSource& frames,
                              FrameIdx frame,
                              const PyramidOptions& options) {
  const PinholeCamera& camera = frames.camera();
  Result<StoredDepth> depth = frames.ReadStoredDepth(frame);
  if (!depth.ok()) return depth.error();
  Result<BrightnessImage> brightness = frames.ReadBrightness(frame, WorkReduction(camera, options));
  if (!brightness.ok()) return brightness.error();
  FramePyramid pyramid = BuildPyramid(*depth, std::move(*brightness), camera, options);
  if (pyramid.empty()) return InvalidInput("depth image has not the size of the camera");
  return ReadFrame{std::move(pyramid), *std::move(depth)};
}

}  // namespace deepslam::odometry
