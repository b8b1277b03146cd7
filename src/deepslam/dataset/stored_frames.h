// A capture as it is stored: images in their own size and units, before anything is registered,
// resampled or turned to metres. Layouts implement it (layout.h); frames for the stages
// (capture_frame_source.h) and `convert` (convert.h) are made from it.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/core/result.h"
#include "deepslam/dataset/image_files.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::dataset {

struct CaptureCameras {
  PinholeCamera colour;
  PinholeCamera depth;
  Pose3 colour_from_depth;
  double depth_units_per_m = 0;  // raw value of one metre

  // A depth pixel shows the same point as the colour pixel of the same place.
  [[nodiscard]] bool registered() const { return depth == colour && colour_from_depth == Pose3(); }
};

struct StoredFrame {
  double colour_time_s = 0;  // capture clock
  double depth_time_s = 0;
  std::string colour_name;  // the name foreign annotations use for the colour image
  std::optional<Pose3> world_from_colour;
};

// A colour image in the form it has in the capture.
struct StoredColour {
  ImageCodec codec = ImageCodec::kOther;
  std::string bytes;   // of the PNG or JPEG file; empty for kOther
  ColourImage pixels;  // for kOther
  std::string name;    // file, for messages
};

class StoredFrames {
 public:
  StoredFrames(const CaptureCameras& cameras, std::vector<StoredFrame> frames)
      : cameras_(cameras), frames_(std::move(frames)) {}
  virtual ~StoredFrames() = default;
  StoredFrames(const StoredFrames&) = delete;
  StoredFrames& operator=(const StoredFrames&) = delete;

  [[nodiscard]] const CaptureCameras& cameras() const { return cameras_; }
  [[nodiscard]] const std::vector<StoredFrame>& frames() const { return frames_; }

  // Thread-safe. An error means that this frame is unusable; others may be fine.
  [[nodiscard]] virtual Result<StoredColour> ReadColour(std::size_t i) const = 0;
  // Of the depth camera's size.
  [[nodiscard]] virtual Result<RawDepthImage> ReadDepth(std::size_t i) const = 0;
  // Colour of an earlier frame takes as long as of all frames before it (a video).
  [[nodiscard]] virtual bool colour_in_order() const { return false; }
  // Every `step`-th of them, from the first on; nothing is held of the others.
  [[nodiscard]] virtual std::shared_ptr<const StoredFrames> Every(std::size_t step) const = 0;

 private:
  CaptureCameras cameras_;
  std::vector<StoredFrame> frames_;
};

// The pixels, of the camera's size.
[[nodiscard]] Result<ColourImage> DecodeStored(StoredColour stored, const PinholeCamera& camera);

}  // namespace deepslam::dataset
