#include "deepslam/refine/evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <optional>

#include "deepslam/core/check.h"
#include "deepslam/core/parallel.h"
#include "deepslam/core/wide_vectors.h"
#include "deepslam/scene/voxel_grid.h"
#include "deepslam/shape/depth_view.h"

namespace deepslam::refine {
namespace {

constexpr double kMaxShell_m = 0.04;  // boards of large things are no thicker for their voxels

// Of a column of voxels.
struct ColumnVotes {
  std::array<std::int32_t, kGridSize> free = {};
  std::array<std::int32_t, kGridSize> grazed = {};
  std::array<std::int32_t, kGridSize> object = {};
  std::array<std::int32_t, kGridSize> other = {};
};

// A view, asked about the grid's voxels.
class CarvingView {
 public:
  CarvingView(const PlacedView& placed)
      : view_(placed.view),
        camera_from_grid_(placed.camera_from_grid),
        depth_(*placed.view, camera_from_grid_.RigidPart()),
        upward_m_((camera_from_grid_.rotation * Eigen::Vector3d(0, 0, VoxelM())).cast<float>()),
        grazed_m_(static_cast<float>(shape::kGrazedVoxels * VoxelM())),
        behind_m_(
            static_cast<float>(std::min(kMaxShell_m, RefineOptions::kSurfaceVoxels * VoxelM()))) {}

  // On the column of voxels (i, j).
  void Vote(int i, int j, ColumnVotes& votes) const {
    const Eigen::Vector3f lowest = (camera_from_grid_ * VoxelGrid::Center(i, j, 0)).cast<float>();
    shape::DepthView::Line column;
    depth_.PixelsAlong(lowest, upward_m_, column);
    const float* const depths_m = view_->depth_crop_m.data();
    const std::uint8_t* const in_mask = view_->mask_crop.data();
    const float* const cosines = depth_.cosines().data();
    std::array<float, kGridSize> depth_m;
    std::array<float, kGridSize> cosine;
    std::array<std::int32_t, kGridSize> is_object;
    for (std::size_t k = 0; k < kGridSize; ++k) {  // without branches
      const auto pixel =
          static_cast<std::size_t>(column.pixel[k] == kNowhere ? 0 : column.pixel[k]);
      depth_m[k] = depths_m[pixel];
      cosine[k] = cosines[pixel];
      is_object[k] = in_mask[pixel];
    }
    for (std::size_t k = 0; k < kGridSize; ++k) {
      const bool is_known = (column.pixel[k] != kNowhere) & (depth_m[k] > 0) &
                            (depth_m[k] <= std::numeric_limits<float>::max()) &
                            (column.z_m[k] <= depth_m[k] + behind_m_);
      const float before_m = depth_m[k] - column.z_m[k];
      const bool is_before = before_m > 0;
      const bool is_clear = cosine[k] * before_m > grazed_m_;
      votes.free[k] += (is_known & is_clear) ? 1 : 0;
      votes.grazed[k] += (is_known & is_before & !is_clear) ? 1 : 0;
      votes.object[k] += (is_known & !is_before & (is_object[k] != 0)) ? 1 : 0;
      votes.other[k] += (is_known & !is_before & (is_object[k] == 0)) ? 1 : 0;
    }
  }

 private:
  static constexpr std::int32_t kNowhere = shape::DepthView::kNowhere;

  [[nodiscard]] double VoxelM() const { return kVoxelSize * camera_from_grid_.scale; }

  const ObjectView* view_;
  Similarity3 camera_from_grid_;
  shape::DepthView depth_;
  Eigen::Vector3f upward_m_;  // from a voxel to the one above, camera
  float grazed_m_;
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

// On the voxels (i, 0, 0) to (i, 63, 63); `asked` and `votes` are theirs.
DEEPSLAM_WIDE_VECTORS void VoteInSlice(std::span<const CarvingView> views,
                                       int i,
                                       std::span<const std::uint8_t> asked,
                                       std::span<Votes> votes) {
  std::array<ColumnVotes, kGridSize> columns;
  std::array<bool, kGridSize> is_asked;
  for (std::size_t j = 0; j < kGridSize; ++j) {
    const std::span<const std::uint8_t> column = asked.subspan(j * kGridSize, kGridSize);
    is_asked[j] = std::any_of(column.begin(), column.end(), [](auto a) { return a != 0; });
  }
  // A view at a time: columns side by side meet the same pixels.
  for (const CarvingView& view : views) {
    for (std::size_t j = 0; j < kGridSize; ++j) {
      if (is_asked[j]) view.Vote(i, static_cast<int>(j), columns[j]);
    }
  }
  for (std::size_t n = 0; n < votes.size(); ++n) {
    const ColumnVotes& column = columns[n / kGridSize];
    const std::size_t k = n % kGridSize;
    if (asked[n] == 0) continue;
    votes[n] = {column.free[k], column.grazed[k], column.object[k], column.other[k]};
  }
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
                              std::span<const std::uint8_t> asked) {
  std::vector<CarvingView> carving;
  for (const PlacedView& placed : UsableViews(views)) carving.emplace_back(placed);
  std::vector<Votes> votes(VoxelGrid().occupied.size());
  DEEPSLAM_CHECK(asked.size() == votes.size(), "an entry per voxel");
  constexpr std::size_t kSlice = std::size_t{kGridSize} * kGridSize;
  ParallelFor(kGridSize, [&](std::size_t i) {
    VoteInSlice(carving,
                static_cast<int>(i),
                asked.subspan(i * kSlice, kSlice),
                std::span(votes).subspan(i * kSlice, kSlice));
  });
  return votes;
}

std::vector<Evidence> CarveEvidence(std::span<const PlacedView> views) {
  const std::vector<std::uint8_t> everywhere(VoxelGrid().occupied.size(), 1);
  const std::vector<Votes> votes = CountVotes(views, everywhere);
  const std::size_t num_views = UsableViews(views).size();
  std::vector<Evidence> evidence(votes.size());
  std::transform(votes.begin(), votes.end(), evidence.begin(), [&](const Votes& of_voxel) {
    return Majority(of_voxel, num_views);
  });
  return evidence;
}

}  // namespace deepslam::refine
