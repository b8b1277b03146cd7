// Fuses a whole capture into a coarse surface and the space that was looked through, in a second or
// two.
#pragma once

#include <memory>

#include "deepslam/core/options.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame.h"
#include "deepslam/fuse/choose_frames.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/coarse_surface.h"

namespace deepslam::fuse {

struct CoarseOptions {
  double voxel_m = 0.03;
  // Surfaces of one thing that lie nearer than this to each other, back to back, blur: walls are
  // thicker.
  static constexpr double kTruncation_m = 0.06;
  // A Kinect's deviation is little more than a voxel here, 3.5 cm (depth_noise.h): what is farther
  // falls apart into layers. Noisier frames count as far as theirs is within the truncation.
  static constexpr double kMaxDepth_m = 4.6;
  // Rays are followed this far: one metre past max depth, since free space needs no precise end.
  static constexpr double kSpaceRange_m = 6.0;
  static constexpr int kMinComponentFaces =
      20;                         // smaller connected components are noise: 1 dm^2 of surface
  int max_voxel_blocks = 40'000;  // of 16^3 voxels: 19 x 19 x 6 m of nothing but surface
};
void Describe(OptionsVisitor& visitor, CoarseOptions& options);

// Frames for it: a third of what a fine surface takes sees everything still from several places.
[[nodiscard]] FrameChoice CoarseFrameChoice();

// Frames are added in the order of the calls; equal calls give equal surfaces, whatever the number
// of threads.
class CoarseFusion {
 public:
  explicit CoarseFusion(const CoarseOptions& options);
  ~CoarseFusion();
  CoarseFusion(CoarseFusion&&) noexcept;
  CoarseFusion& operator=(CoarseFusion&&) noexcept;

  // Adds a frame; its colour may be missing (an empty image), and the surface then has none, if it
  // misses in any. Errors: a depth image of another size than the camera's, a colour image of
  // another than the depth's, a camera or pose that is not finite. Nothing is changed then. Where
  // the surface outgrows max_voxel_blocks, the frame's surface is left out: told by surface_full().
  Status Integrate(const Frame& frame, const PinholeCamera& camera, const Pose3& level_from_camera);
  [[nodiscard]] bool surface_full() const;

  // In the world of the poses; level_from_tracking and has_ground are the caller's to set.
  [[nodiscard]] CoarseSurface Take() &&;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace deepslam::fuse
