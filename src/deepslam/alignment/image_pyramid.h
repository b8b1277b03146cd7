// Frames prepared for alignment: smoothed depth and intensity on a pyramid, and what other frames
// are aligned to, as flat float arrays.
#pragma once

#include <cstddef>
#include <vector>

#include "deepslam/core/ids.h"
#include "deepslam/core/options.h"
#include "deepslam/core/result.h"
#include "deepslam/core/unfilled.h"
#include "deepslam/frames/frame.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/frames/stored_depth.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/depth_noise.h"

namespace deepslam::alignment {

// Depth of one surface within a block or window differs by at most this many standard deviations of
// its noise.
inline constexpr float kSameSurfaceSigmas = 4.0F;

struct PyramidOptions {
  int work_width_px =
      320;  // the finest level is the capture reduced by a whole factor to at most this width
  int num_levels = 4;        // each level half as wide as the one before
  double min_depth_m = 0.2;  // nearer or farther depth is taken as invalid
  double max_depth_m = 8.0;
  // Edge-respecting 5 x 5 mean on the finest level; over a wider window and twice where the depth
  // is noisier than `noise`.
  bool smooth_depth = true;
  DepthNoise noise;
};

void Describe(OptionsVisitor& visitor, PyramidOptions& options);

// One pixel of the surface as a reference of projective association. All zero where the surface has
// no normal. Trivial, as the one below, so that rows of them are copied at once.
struct SurfacePixel {
  float nx, ny, nz;  // unit normal, camera frame, towards the camera
  float offset_m;  // n . q of the pixel's point q, < 0; the residual of point p is n . p - offset_m
};

// Intensity and its derivatives, grey levels (0-255) and grey levels per pixel of this level.
struct IntensityPixel {
  float value, du, dv;
};

// All images are row-major, width * height.
struct PyramidLevel {
  PinholeCamera camera;
  UnfilledVector<float> depth_m;  // 0 = invalid
  IntensityImage intensity;       // empty when the frame had no colour
  DepthNoise noise;               // of the depth, as it was found
  // Empty but of references (reference_pixels.h).
  UnfilledVector<SurfacePixel> surface;
  UnfilledVector<float> signed_depth_m;      // depth_m, negated where there is no normal
  UnfilledVector<IntensityPixel> gradients;  // ... and when the frame had no colour
};

struct FramePyramid {
  std::vector<PyramidLevel> levels;  // finest first; at least one
  double valid_share = 0;            // pixels of the finest level with a normal, of all; from some
  // Deviation of the smoothed depth in units of DepthNoise, measured across this frame; 1 to 8.
  double noise_scale = 1;
  int reduction = 1;       // of the finest level against the capture
  bool one_depth = false;  // the same at every pixel: a sensor that hangs; even a wall has noise

  [[nodiscard]] bool empty() const { return levels.empty(); }
};

// Levels that hold enough to align by, at least one. Coarser ones hold too few points for all six
// directions; they serve the rotation search.
[[nodiscard]] inline std::size_t NumAlignmentLevels(const FramePyramid& pyramid) {
  constexpr int kMinWidth = 60;  // px: narrower ones of 4 : 3 have less than 2,700 pixels
  std::size_t count = 1;
  while (count < pyramid.levels.size() && pyramid.levels[count].camera.width >= kMinWidth) ++count;
  return count;
}

// By how much the capture is reduced for the finest level: a whole factor.
[[nodiscard]] int WorkReduction(const PinholeCamera& camera, const PyramidOptions& options);

// The colour image may be empty; a colour image of another size than the depth is ignored. Empty
// for an empty depth.
[[nodiscard]] FramePyramid BuildPyramid(const Frame& frame,
                                        const PinholeCamera& camera,
                                        const PyramidOptions& options);

// The same of its parts; `intensity` is that of the finest level (IntensityOf by WorkReduction).
[[nodiscard]] FramePyramid BuildPyramid(const StoredDepth& depth,
                                        IntensityImage intensity,
                                        const PinholeCamera& camera,
                                        const PyramidOptions& options);

// A frame of a capture read for alignment: no more of its colour than its intensity, at the size
// that is worked on.
struct ReadFrame {
  FramePyramid pyramid;  // never empty
  StoredDepth depth;     // what it was made of
};

// An error where the frame cannot be read or its depth has not the camera's size.
[[nodiscard]] Result<ReadFrame> ReadPyramid(const FrameSource& frames,
                                            FrameIdx frame,
                                            const PyramidOptions& options);

}  // namespace deepslam::alignment
