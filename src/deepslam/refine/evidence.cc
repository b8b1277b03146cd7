#include "deepslam/refine/evidence.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "deepslam/core/parallel.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::refine {
namespace {

constexpr float kBeforeSurface = 0.5;  // voxels

// The grid's first voxel and its steps in the camera, metres.
class VoxelRays {
 public:
  VoxelRays(const PlacedView& placed, const RefineOptions& options)
      : view_(*placed.view),
        before_m_(static_cast<float>(kBeforeSurface * kVoxelSize * placed.camera_from_grid.scale)),
        behind_m_(static_cast<float>(options.surface_voxels * kVoxelSize *
                                     placed.camera_from_grid.scale)) {
    const Similarity3& camera_from_grid = placed.camera_from_grid;
    const Eigen::Vector3d origin = camera_from_grid * VoxelGrid::Center(0, 0, 0);
    first_ = origin.cast<float>();
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d next = VoxelGrid::Center(axis == 0, axis == 1, axis == 2);
      steps_.col(axis) = (camera_from_grid * next - origin).cast<float>();
    }
  }

  [[nodiscard]] Evidence At(int i, int j, int k) const {
    const Eigen::Vector3f p =
        first_ + steps_ * Eigen::Vector3f(
                              static_cast<float>(i), static_cast<float>(j), static_cast<float>(k));
    if (!(p.z() > 0)) return Evidence::kUnknown;
    const PinholeCamera& camera = view_.camera;
    const float u = static_cast<float>(camera.fx) * p.x() / p.z() + static_cast<float>(camera.cx);
    const float v = static_cast<float>(camera.fy) * p.y() / p.z() + static_cast<float>(camera.cy);
    if (!(std::abs(u) < 1e6F && std::abs(v) < 1e6F)) return Evidence::kUnknown;
    const int x = static_cast<int>(std::lround(u));
    const int y = static_cast<int>(std::lround(v));
    if (!view_.depth_crop_m.Contains(x, y)) return Evidence::kUnknown;
    const float depth_m = view_.depth_crop_m(x, y);
    if (!(depth_m > 0) || !std::isfinite(depth_m)) return Evidence::kUnknown;
    if (p.z() < depth_m - before_m_) return Evidence::kFree;
    const bool is_near = p.z() <= depth_m + behind_m_;
    return is_near && view_.mask_crop(x, y) != 0 ? Evidence::kSolid : Evidence::kUnknown;
  }

 private:
  const ObjectView& view_;
  float before_m_;
  float behind_m_;
  Eigen::Vector3f first_;
  Eigen::Matrix3f steps_;
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

Evidence Majority(std::span<const VoxelRays> views, int i, int j, int k) {
  int num_free = 0;
  int num_solid = 0;
  for (const VoxelRays& view : views) {
    const Evidence said = view.At(i, j, k);
    if (said == Evidence::kFree) ++num_free;
    if (said == Evidence::kSolid) ++num_solid;
  }
  if (num_free + num_solid == 0) return Evidence::kUnknown;
  if (num_free > num_solid) return Evidence::kFree;
  return num_solid > 1 || views.size() == 1 ? Evidence::kSolid : Evidence::kFaint;
}

}  // namespace

std::vector<Evidence> CarveEvidence(std::span<const PlacedView> views,
                                    const RefineOptions& options) {
  std::vector<VoxelRays> rays;
  for (const PlacedView& placed : views) {
    if (IsUsable(placed)) rays.emplace_back(placed, options);
  }
  std::vector<Evidence> evidence(VoxelGrid().occupied.size(), Evidence::kUnknown);
  ParallelFor(kGridSize, [&](std::size_t slab) {
    const int i = static_cast<int>(slab);
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k)
        evidence[VoxelGrid::Index(i, j, k)] = Majority(rays, i, j, k);
    }
  });
  return evidence;
}

}  // namespace deepslam::refine
