#include "deepslam/dataset/memory_frame_source.h"

#include <string>
#include <utility>

#include "deepslam/frames/intensity.h"

namespace deepslam::dataset {

MemoryFrameSource::MemoryFrameSource(const PinholeCamera& camera,
                                     std::vector<Frame> frames,
                                     std::vector<std::optional<Pose3>> world_from_camera)
    : camera_(camera),
      frames_(std::move(frames)),
      world_from_camera_(std::move(world_from_camera)) {
  DEEPSLAM_CHECK(world_from_camera_.empty() || world_from_camera_.size() == frames_.size(),
                 "one pose per frame, or none at all");
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    frames_[i].idx = FrameIdx{static_cast<std::int32_t>(i)};
  }
}

const Frame& MemoryFrameSource::At(FrameIdx frame) const {
  DEEPSLAM_CHECK(frame.valid() && frame.value < num_frames(), "frame outside the capture");
  return frames_[static_cast<std::size_t>(frame.value)];
}

int MemoryFrameSource::num_frames() const { return static_cast<int>(frames_.size()); }

double MemoryFrameSource::time_s(FrameIdx frame) const { return At(frame).time_s; }

Result<Frame> MemoryFrameSource::Read(FrameIdx frame) const {
  const Frame& found = At(frame);
  if (found.colour.empty() && found.depth_m.empty()) {
    return InvalidInput("frame " + std::to_string(frame.value) + " holds no image");
  }
  return found;
}

Result<Frame> MemoryFrameSource::ReadDepth(FrameIdx frame) const {
  const Frame& found = At(frame);
  if (found.depth_m.empty()) {
    return InvalidInput("frame " + std::to_string(frame.value) + " holds no depth");
  }
  return Frame{found.idx, found.time_s, ColourImage(), found.depth_m};
}

Result<Frame> MemoryFrameSource::ReadColour(FrameIdx frame) const {
  const Frame& found = At(frame);
  if (found.colour.empty()) {
    return InvalidInput("frame " + std::to_string(frame.value) + " holds no colour");
  }
  return Frame{found.idx, found.time_s, found.colour, DepthImage()};
}

Result<IntensityImage> MemoryFrameSource::ReadIntensity(FrameIdx frame, int factor) const {
  return IntensityOf(At(frame).colour, factor);
}

std::optional<Pose3> MemoryFrameSource::capture_world_from_camera(FrameIdx frame) const {
  DEEPSLAM_CHECK(frame.valid() && frame.value < num_frames(), "frame outside the capture");
  if (world_from_camera_.empty()) return std::nullopt;
  return world_from_camera_[static_cast<std::size_t>(frame.value)];
}

}  // namespace deepslam::dataset
