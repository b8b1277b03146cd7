// Images of real lenses as a pinhole would have taken them, and images of a camera that changes
// from frame to frame (a phone that refocuses) as one that does not.
//
// Colour is interpolated between its four neighbours, depth as its inverse where they are of one
// surface (exact on planes; depth is along the axis, which a lens leaves alone), else the nearest
// one's is taken. Where the lens shows nothing colour is black and depth invalid. Maps are made
// once for each lens; frames whose camera is the common one, without a lens, pass as they are.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "deepslam/dataset/stored_frames.h"
#include "deepslam/geometry/lens_distortion.h"

namespace deepslam::dataset {

// What the images were taken through, where CaptureCameras alone does not say it.
struct Optics {
  std::optional<LensDistortion> colour;
  std::optional<LensDistortion> depth;
  // One per frame, of the sizes of CaptureCameras'; empty: those.
  std::vector<PinholeCamera> colour_cameras;
  std::vector<PinholeCamera> depth_cameras;

  [[nodiscard]] bool is_pinhole() const {
    return !colour && !depth && colour_cameras.empty() && depth_cameras.empty();
  }
};

// `frames` themselves where nothing is to be done.
[[nodiscard]] std::shared_ptr<const StoredFrames> RectifyFrames(
    std::shared_ptr<const StoredFrames> frames, Optics optics);

}  // namespace deepslam::dataset
