#include "deepslam/fuse/frame_check.h"

#include <cmath>
#include <string>

namespace deepslam::fuse {

Status CheckFrame(const Frame& frame, const PinholeCamera& camera, const Pose3& world_from_camera) {
  const std::string name = "frame " + std::to_string(frame.idx.value);
  const int width = frame.depth_m.width();
  const int height = frame.depth_m.height();
  if (frame.depth_m.empty() || width != camera.width || height != camera.height) {
    return InvalidInput(name + ": depth is " + std::to_string(width) + " x " +
                        std::to_string(height) + ", the camera " + std::to_string(camera.width) +
                        " x " + std::to_string(camera.height));
  }
  if (!frame.colour.empty() && (frame.colour.width() != width || frame.colour.height() != height)) {
    return InvalidInput(name + ": colour and depth differ in size");
  }
  if (!(camera.fx > 0) || !(camera.fy > 0) || !std::isfinite(camera.fx + camera.fy) ||
      !std::isfinite(camera.cx) || !std::isfinite(camera.cy)) {
    return InvalidInput(name + ": focal length or principal point is not usable");
  }
  // Blocks are counted in 32-bit integers: a pose far off would overflow them.
  constexpr double kMaxPlace = 1e5;
  if (!world_from_camera.Matrix().allFinite() ||
      world_from_camera.translation_m.cwiseAbs().maxCoeff() > kMaxPlace) {
    return InvalidInput(name + ": pose is not finite or absurdly far");
  }
  return Ok();
}

}  // namespace deepslam::fuse
