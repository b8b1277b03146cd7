// Renders a world frame by frame: what a hand-held RGB-D camera would have recorded, and the truth
// beside it.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/frames/frame.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/synth/world.h"

namespace deepslam::synth {

struct RenderedFrame {
  Frame frame;  // with the sensor's faults
  DepthImage true_depth_m;
  Image<std::uint8_t> instances;  // 0 = room and clutter, k + 1 = object k
  Pose3 world_from_camera;
};

class CaptureRenderer {
 public:
  explicit CaptureRenderer(World world);
  ~CaptureRenderer();
  CaptureRenderer(CaptureRenderer&&) noexcept;

  [[nodiscard]] int num_frames() const;  // without the dropped ones
  [[nodiscard]] const World& world() const;
  // The same frame for the same world, whatever was rendered before and on however many threads.
  [[nodiscard]] RenderedFrame Render(int frame) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace deepslam::synth
