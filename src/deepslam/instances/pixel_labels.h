// Which thing each pixel of a frame is of: the one on whose surface its depth lies, and where the
// surface of the capture is too coarse to hold it, the one it hangs together with in this frame.
#pragma once

#include <span>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/frames/pixel_mask.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/instances/find_instances.h"
#include "deepslam/instances/nearest_elements.h"
#include "deepslam/instances/surface_elements.h"

namespace deepslam::instances {

// One frame as it is labelled. Depth is 0 where invalid.
struct MeasuredView {
  const DepthImage& depth_m;
  PinholeCamera camera;
  Pose3 level_from_camera;
  double max_depth_m = 0;  // farther depth is nobody's
};

// A surface that was divided into things.
struct DividedSurface {
  const SurfaceElements& elements;
  const NearestElements& nearest;
  const Instances& instances;
};

// What a pixel is of that is no instance's (indices from 0).
inline constexpr int kRoomPixel = -1;        // floor, wall, out of reach
inline constexpr int kLoosePixel = -2;       // measured, on no surface of the capture
inline constexpr int kUnmeasuredPixel = -3;  // without depth

struct PixelLabels {
  Image<int> instance;  // index or one of the above
  // Of each instance: elements that some pixel lies on.
  std::vector<int> num_visible;
};

// By the surface alone.
[[nodiscard]] PixelLabels LabelBySurface(const DividedSurface& surface, const MeasuredView& view);

// What a detector shows of an instance in this frame.
struct ShownInstance {
  int instance = -1;
  const PixelMask* mask = nullptr;
};

// Backs, slats, legs and leaves that the surface of the capture lost: pixels in the mask of a
// detection of a thing are the thing's where they hang together, in the ground plan, with its box,
// however high they lie. They are loose or of a rejected piece that detections name alike.
void GrowIntoMasks(const DividedSurface& surface,
                   const MeasuredView& view,
                   std::span<const ShownInstance> shown,
                   PixelLabels& labels);

// Legs, slats and rims that are thinner than the surface's voxels: loose pixels take the label of
// the nearest pixel of a thing that a chain of neighbouring pixels without a depth edge leads to.
// Nothing grows out of the thing's box by more than two voxels, but downwards.
void GrowIntoLoose(const DividedSurface& surface, const MeasuredView& view, PixelLabels& labels);

// Unmeasured pixels between two pixels of one thing, in their row or column, that lie at most
// `gap_m` apart at the nearer one's depth, become the thing's.
void FillUnmeasured(const MeasuredView& view, double gap_m, PixelLabels& labels);

}  // namespace deepslam::instances
