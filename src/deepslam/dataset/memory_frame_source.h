// Frames held in memory, for tests and for programs that already have them.
#pragma once

#include <optional>
#include <vector>

#include "deepslam/frames/frame_source.h"

namespace deepslam::dataset {

class MemoryFrameSource final : public FrameSource {
 public:
  // `idx` of the frames is set to their position. A frame whose colour and depth are both empty
  // reads as an error (an unusable frame). `world_from_camera` is empty or has one entry per frame.
  MemoryFrameSource(const PinholeCamera& camera,
                    std::vector<Frame> frames,
                    std::vector<std::optional<Pose3>> world_from_camera = {});

  [[nodiscard]] int num_frames() const override;
  [[nodiscard]] const PinholeCamera& camera() const override { return camera_; }
  [[nodiscard]] double time_s(FrameIdx frame) const override;
  [[nodiscard]] Result<Frame> Read(FrameIdx frame) const override;
  [[nodiscard]] Result<Frame> ReadDepth(FrameIdx frame) const override;
  [[nodiscard]] Result<Frame> ReadColour(FrameIdx frame) const override;
  // Empty where the frame has no colour: as in Read, that is no error.
  [[nodiscard]] Result<IntensityImage> ReadIntensity(FrameIdx frame, int factor) const override;
  [[nodiscard]] std::optional<Pose3> capture_world_from_camera(FrameIdx frame) const override;

 private:
  [[nodiscard]] const Frame& At(FrameIdx frame) const;

  PinholeCamera camera_;
  std::vector<Frame> frames_;
  std::vector<std::optional<Pose3>> world_from_camera_;
};

}  // namespace deepslam::dataset
