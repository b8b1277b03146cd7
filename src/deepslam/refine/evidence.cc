#include "deepslam/refine/evidence.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>

#include "deepslam/core/check.h"
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
      : view_(placed.view),
        camera_from_grid_(placed.camera_from_grid),
        depth_(*placed.view, camera_from_grid_.RigidPart(), shape::DepthView::Slopes::kIgnored),
        upward_m_((camera_from_grid_.rotation * Eigen::Vector3d(0, 0, VoxelM())).cast<float>()),
        before_m_(static_cast<float>(kBeforeSurface * VoxelM())),
        behind_m_(static_cast<float>(std::min(kMaxShell_m, options.surface_voxels * VoxelM()))) {}

  // On the column of voxels (i, j), where `asked` is not 0; both from the lowest voxel up.
  void Vote(int i, int j, std::span<const std::uint8_t> asked, std::span<Votes> votes) const {
    const Eigen::Vector3f lowest = (camera_from_grid_ * VoxelGrid::Center(i, j, 0)).cast<float>();
    shape::DepthView::Line column;
    depth_.PixelsAlong(lowest, upward_m_, column);
    for (std::size_t k = 0; k < votes.size(); ++k) {
      if (asked[k] != 0 && column.pixel[k] != shape::DepthView::kNowhere)
        Vote(static_cast<std::size_t>(column.pixel[k]), column.z_m[k], votes[k]);
    }
  }

 private:
  void Vote(std::size_t pixel, float z_m, Votes& votes) const {
    const float depth_m = view_->depth_crop_m.data()[pixel];
    if (!(depth_m > 0) || !std::isfinite(depth_m) || z_m > depth_m + behind_m_) return;
    const bool is_before = z_m < depth_m - before_m_;
    const bool is_object = !is_before && view_->mask_crop.data()[pixel] != 0;
    ++(is_before ? votes.free : is_object ? votes.object : votes.other);
  }

  [[nodiscard]] double VoxelM() const { return kVoxelSize * camera_from_grid_.scale; }

  const ObjectView* view_;
  Similarity3 camera_from_grid_;
  shape::DepthView depth_;
  Eigen::Vector3f upward_m_;  // from a voxel to the one above, camera
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
  return votes.IsMeasured(num_views) ? Evidence::kSolid : Evidence::kFaint;
}

}  // namespace

std::vector<PlacedView> UsableViews(std::span<const PlacedView> views) {
  std::vector<PlacedView> usable;
  std::copy_if(views.begin(), views.end(), std::back_inserter(usable), IsUsable);
  return usable;
}

std::vector<Votes> CountVotes(std::span<const PlacedView> views,
                              std::span<const std::uint8_t> asked,
                              const RefineOptions& options) {
  std::vector<CarvingView> carving;
  for (const PlacedView& placed : UsableViews(views)) carving.emplace_back(placed, options);
  std::vector<Votes> votes(VoxelGrid().occupied.size());
  DEEPSLAM_CHECK(asked.size() == votes.size(), "an entry per voxel");
  ParallelFor(kGridSize, [&](std::size_t slab) {
    const int i = static_cast<int>(slab);
    // A view at a time: columns side by side meet the same pixels.
    for (const CarvingView& view : carving) {
      for (int j = 0; j < kGridSize; ++j) {
        const std::size_t column = VoxelGrid::Index(i, j, 0);
        const std::span<const std::uint8_t> of_column = asked.subspan(column, kGridSize);
        if (std::all_of(of_column.begin(), of_column.end(), [](auto a) { return a == 0; }))
          continue;
        view.Vote(i, j, of_column, std::span(votes).subspan(column, kGridSize));
      }
    }
  });
  return votes;
}

std::vector<Evidence> CarveEvidence(std::span<const PlacedView> views,
                                    const RefineOptions& options) {
  const std::vector<std::uint8_t> everywhere(VoxelGrid().occupied.size(), 1);
  const std::vector<Votes> votes = CountVotes(views, everywhere, options);
  const std::size_t num_views = UsableViews(views).size();
  std::vector<Evidence> evidence(votes.size());
  std::transform(votes.begin(), votes.end(), evidence.begin(), [&](const Votes& of_voxel) {
    return Majority(of_voxel, num_views);
  });
  return evidence;
}

}  // namespace deepslam::refine
