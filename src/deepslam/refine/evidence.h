// What all depth of an object says about the voxels of a shape: space carving (Kutulakos and Seitz
// 2000) on the grid of a decoder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "deepslam/geometry/similarity.h"
#include "deepslam/refine/refine_options.h"
#include "deepslam/scene/object_view.h"

namespace deepslam::refine {

enum class Evidence : std::uint8_t {
  kUnknown,  // nobody saw it, or it lies behind what was seen
  kFree,     // rays went on behind it
  kFaint,    // the object's surface was measured in it by one view of several
  kSolid,    // ... by two at least, or by the only one
};

// A view and where the grid stands in it; the grid's axes and unit as in VoxelGrid.
struct PlacedView {
  const ObjectView* view = nullptr;
  Similarity3 camera_from_grid;
};

// The views whose crops fit together and whose poses are finite.
[[nodiscard]] std::vector<PlacedView> UsableViews(std::span<const PlacedView> views);

// How many views say what of a voxel by its middle. A measured surface is solid from where it was
// measured to kSurfaceVoxels (4 cm at most) behind it, along the ray, so that voxels end at the
// surface in the mean. Before it a ray passed the voxel, but grazed it within a quarter of a voxel
// of the surface's plane, where noise decides.
struct Votes {
  int free = 0;
  int grazed = 0;
  int object = 0;  // surface of the object's segment
  int other = 0;   // surface outside it: of something else, or of what segmentation has missed

  // More views went on behind it than found any surface in it.
  [[nodiscard]] bool IsFree() const { return free > object + other; }
  // Anything's: found by two of several views at least.
  [[nodiscard]] bool HasSurface(std::size_t num_views) const {
    return object + other >= (num_views > 1 ? 2 : 1);
  }
  // The object's: likewise, and by no fewer than went through.
  [[nodiscard]] bool IsMeasured(std::size_t num_views) const {
    return object >= (num_views > 1 ? 2 : 1) && object >= free + grazed;
  }
  Votes& operator+=(const Votes& others) {
    free += others.free;
    grazed += others.grazed;
    object += others.object;
    other += others.other;
    return *this;
  }
};

// One entry per voxel, index order of VoxelGrid, as in `asked`: no votes where that is 0. Views
// that are not usable say nothing.
[[nodiscard]] std::vector<Votes> CountVotes(std::span<const PlacedView> views,
                                            std::span<const std::uint8_t> asked);

// Likewise for all voxels: what more views say than say the contrary, solid where they are even.
// Surface of something else says nothing.
[[nodiscard]] std::vector<Evidence> CarveEvidence(std::span<const PlacedView> views);

}  // namespace deepslam::refine
