#include "deepslam/frames/frame_source.h"

#include <utility>

#include "deepslam/frames/brightness.h"

namespace deepslam {

Result<StoredDepth> FrameSource::ReadStoredDepth(FrameIdx frame) const {
  Result<Frame> read = ReadDepth(frame);
  if (!read.ok()) return read.error();
  return StoredDepth(std::move(read->depth_m));
}

Result<BrightnessImage> FrameSource::ReadBrightness(FrameIdx frame, int factor) const {
  const Result<Frame> read = ReadColour(frame);
  if (!read.ok()) return read.error();
  return BrightnessOf(read->colour, factor);
}

void FrameSource::GiveBack(Frame /*frame*/) const {}

}  // namespace deepslam
