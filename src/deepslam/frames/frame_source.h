// The seam between captures on disk (or in memory) and everything else. Frames are read one at a
// time, never all held.
#pragma once

#include <optional>

#include "deepslam/core/ids.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame.h"
#include "deepslam/frames/stored_depth.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"

namespace deepslam {

class FrameSource {
 public:
  virtual ~FrameSource() = default;

  [[nodiscard]] virtual int num_frames() const = 0;
  [[nodiscard]] virtual const PinholeCamera& camera() const = 0;
  [[nodiscard]] virtual double time_s(FrameIdx frame) const = 0;
  // Thread-safe. An error means this frame is unusable (unreadable, truncated, wrong size); others
  // may be fine.
  [[nodiscard]] virtual Result<Frame> Read(FrameIdx frame) const = 0;
  // Only the depth, or only the colour, where the other is not needed. The other image of the frame
  // is empty.
  [[nodiscard]] virtual Result<Frame> ReadDepth(FrameIdx frame) const = 0;
  [[nodiscard]] virtual Result<Frame> ReadColour(FrameIdx frame) const = 0;
  // The same depth, as it is stored where it can be.
  [[nodiscard]] virtual Result<StoredDepth> ReadStoredDepth(FrameIdx frame) const;
  // The colour's intensity averaged over blocks of factor x factor pixels (factor 1 to 32). Made
  // of the colour here; sources whose files can be decoded at that size do so, which may differ by
  // the rounding of grey levels. The same whatever was read before.
  [[nodiscard]] virtual Result<IntensityImage> ReadIntensity(FrameIdx frame, int factor) const;
  // Takes back an image that was read here, or both of a frame, that will be asked for again.
  // Thread-safe. Nothing comes of it where a source keeps no images.
  virtual void GiveBack(Frame frame) const;
  // Pose that came with the capture (truth or an AR session), in the capture's own world; nothing
  // where it has none.
  [[nodiscard]] virtual std::optional<Pose3> capture_world_from_camera(FrameIdx frame) const = 0;
};

}  // namespace deepslam
