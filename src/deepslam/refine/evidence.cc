#include "deepslam/refine/evidence.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>

#include "deepslam/core/parallel.h"
#include "deepslam/scene/voxel_grid.h"
#include "deepslam/shape/depth_view.h"

namespace deepslam::refine {
namespace {

constexpr float kBeforeSurface = 0.5;  // voxels
constexpr double kMaxShell_m = 0.025;  // boards of large things are no thicker for their voxels

// A view, asked about the grid's voxels.
class CarvingView {
 public:
  CarvingView(const PlacedView& placed, const RefineOptions& options)
      : depth_(*placed.view,
               {placed.camera_from_grid.rotation, placed.camera_from_grid.translation_m}),
        scale_m_(placed.camera_from_grid.scale),
        before_m_(static_cast<float>(kBeforeSurface * kVoxelSize * scale_m_)),
        behind_m_(static_cast<float>(
            std::min(kMaxShell_m, options.surface_voxels * kVoxelSize * scale_m_))) {}

  [[nodiscard]] Evidence At(int i, int j, int k) const {
    const Eigen::Vector3d center_m = scale_m_ * VoxelGrid::Center(i, j, k);
    const std::optional<shape::DepthView::Reading> reading = depth_.At(center_m.cast<float>());
    if (!reading) return Evidence::kUnknown;
    if (reading->z_m < reading->depth_m - before_m_) return Evidence::kFree;
    const bool is_near = reading->z_m <= reading->depth_m + behind_m_;
    return is_near && reading->is_object ? Evidence::kSolid : Evidence::kUnknown;
  }

 private:
  shape::DepthView depth_;
  double scale_m_;  // metres per unit of the grid
  float before_m_;
  float behind_m_;
};

bool IsUsable(const PlacedView& placed) {
  const ObjectView& view = *placed.view;
  const Similarity3& pose = placed.camera_from_grid;
  return !view.depth_crop_m.empty() && view.mask_crop.width() == view.depth_crop_m.width() &&
         view.mask_crop.height() == view.depth_crop_m.height() && pose.translation_m.allFinite() &&
         pose.rotation.coeffs().allFinite() && std::isfinite(pose.scale) && pose.scale > 0 &&
         std::isfinite(view.camera.fx) && std::isfinite(view.camera.fy) &&
         std::isfinite(view.camera.cx) && std::isfinite(view.camera.cy);
}

Evidence Majority(std::span<const CarvingView> views, int i, int j, int k) {
  int num_free = 0;
  int num_solid = 0;
  for (const CarvingView& view : views) {
    const Evidence said = view.At(i, j, k);
    if (said == Evidence::kFree) ++num_free;
    if (said == Evidence::kSolid) ++num_solid;
  }
  if (num_free + num_solid == 0) return Evidence::kUnknown;
  if (num_free > num_solid) return Evidence::kFree;
  return num_solid > 1 || views.size() == 1 ? Evidence::kSolid : Evidence::kFaint;
}

}  // namespace

std::vector<PlacedView> UsableViews(std::span<const PlacedView> views) {
  std::vector<PlacedView> usable;
  std::copy_if(views.begin(), views.end(), std::back_inserter(usable), IsUsable);
  return usable;
}

std::vector<Evidence> CarveEvidence(std::span<const PlacedView> views,
                                    const RefineOptions& options) {
  std::vector<CarvingView> carving;
  for (const PlacedView& placed : UsableViews(views)) carving.emplace_back(placed, options);
  std::vector<Evidence> evidence(VoxelGrid().occupied.size(), Evidence::kUnknown);
  ParallelFor(kGridSize, [&](std::size_t slab) {
    const int i = static_cast<int>(slab);
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k)
        evidence[VoxelGrid::Index(i, j, k)] = Majority(carving, i, j, k);
    }
  });
  return evidence;
}

}  // namespace deepslam::refine
