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

  void Vote(int i, int j, int k, Votes& votes) const {
    const Eigen::Vector3d center_m = scale_m_ * VoxelGrid::Center(i, j, k);
    const std::optional<shape::DepthView::Reading> reading = depth_.At(center_m.cast<float>());
    if (!reading || reading->z_m > reading->depth_m + behind_m_) return;
    const bool is_before = reading->z_m < reading->depth_m - before_m_;
    ++(is_before ? votes.free : reading->is_object ? votes.object : votes.other);
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

Evidence Majority(const Votes& votes, std::size_t num_views) {
  if (votes.free + votes.object == 0) return Evidence::kUnknown;
  if (votes.free > votes.object) return Evidence::kFree;
  return votes.object > 1 || num_views == 1 ? Evidence::kSolid : Evidence::kFaint;
}

}  // namespace

std::vector<PlacedView> UsableViews(std::span<const PlacedView> views) {
  std::vector<PlacedView> usable;
  std::copy_if(views.begin(), views.end(), std::back_inserter(usable), IsUsable);
  return usable;
}

std::vector<Votes> CountVotes(std::span<const PlacedView> views, const RefineOptions& options) {
  std::vector<CarvingView> carving;
  for (const PlacedView& placed : UsableViews(views)) carving.emplace_back(placed, options);
  std::vector<Votes> votes(VoxelGrid().occupied.size());
  ParallelFor(kGridSize, [&](std::size_t slab) {
    const int i = static_cast<int>(slab);
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        for (const CarvingView& view : carving)
          view.Vote(i, j, k, votes[VoxelGrid::Index(i, j, k)]);
      }
    }
  });
  return votes;
}

std::vector<Evidence> CarveEvidence(std::span<const PlacedView> views,
                                    const RefineOptions& options) {
  const std::vector<Votes> votes = CountVotes(views, options);
  const std::size_t num_views = UsableViews(views).size();
  std::vector<Evidence> evidence(votes.size());
  std::transform(votes.begin(), votes.end(), evidence.begin(), [&](const Votes& of_voxel) {
    return Majority(of_voxel, num_views);
  });
  return evidence;
}

}  // namespace deepslam::refine
