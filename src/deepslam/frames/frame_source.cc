#include "deepslam/frames/frame_source.h"

#include <utility>

#include "deepslam/frames/intensity.h"

namespace deepslam {

Result<StoredDepth> FrameSource::ReadStoredDepth(FrameIdx frame) const {
  Result<Frame> read = ReadDepth(frame);
  if (!read.ok()) return read.error();
  return StoredDepth(std::move(read->depth_m));
}

Result<IntensityImage> FrameSource::ReadIntensity(FrameIdx frame, int factor) const {
  const Result<Frame> read = ReadColour(frame);
  if (!read.ok()) return read.error();
  return IntensityOf(read->colour, factor);
}

void FrameSource::GiveBack(Frame /*frame*/) const {}

}  // namespace deepslam
