#include "deepslam/refine/grid_around.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Geometry>

#include "deepslam/core/order_statistics.h"
#include "deepslam/core/parallel.h"

namespace deepslam::refine {
namespace {

constexpr int kPixelStep = 3;            // of views whose points bound the grid
constexpr std::size_t kOutermost = 100;  // part of these points at either end that may be noise
constexpr int kModelVoxels = 62;
static_assert(kModelVoxels * kVoxelSize == kModelExtent);

using Points = std::vector<Eigen::Vector3d>;

// Measured points of the object within `reach` of the model, all in object units.
Points PointsNear(const shape::ShapeModel& model, const PlacedView& placed, double reach) {
  Points near;
  const ObjectView& view = *placed.view;
  const Similarity3 object_from_camera = placed.camera_from_grid.Inverse();
  for (int v = 0; v < view.depth_crop_m.height(); v += kPixelStep) {
    for (int u = 0; u < view.depth_crop_m.width(); u += kPixelStep) {
      const double depth_m = view.depth_crop_m(u, v);
      if (view.mask_crop(u, v) == 0 || !(depth_m > 0) || !std::isfinite(depth_m)) continue;
      const Eigen::Vector3d p = object_from_camera * (depth_m * view.camera.Ray(u, v));
      if (model.Distance(p.cast<float>()) < reach) near.push_back(p);
    }
  }
  return near;
}

Points PointsNear(const shape::ShapeModel& model, std::span<const PlacedView> views, double reach) {
  std::vector<Points> of_views(views.size());
  ParallelFor(views.size(),
              [&](std::size_t n) { of_views[n] = PointsNear(model, views[n], reach); });
  Points near;
  for (const Points& points : of_views) near.insert(near.end(), points.begin(), points.end());
  return near;
}

// Box of the model and of the points, the outermost of these left out.
Eigen::AlignedBox3d Around(const shape::ShapeModel& model, const Points& points) {
  Eigen::AlignedBox3d box(model.box_min().cast<double>(), model.box_max().cast<double>());
  if (points.empty()) return box;
  std::vector<double> along(points.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(points.begin(), points.end(), along.begin(), [&](const Eigen::Vector3d& p) {
      return p[axis];
    });
    const auto [low, high] = InnerRange(along, kOutermost);
    box.min()[axis] = std::min(box.min()[axis], low);
    box.max()[axis] = std::max(box.max()[axis], high);
  }
  return box;
}

// Moved by half a voxel at most, so that a layer of voxels begins at the floor.
Similarity3 OnFloor(Similarity3 object_from_grid, double floor_z) {
  const double voxel = object_from_grid.scale * kVoxelSize;
  const double layers = (floor_z - object_from_grid.translation_m.z()) / voxel;
  object_from_grid.translation_m.z() = floor_z - voxel * std::round(layers);
  return object_from_grid;
}

// The model's own grid where the box fits into it; else one that holds the box.
Similarity3 ObjectFromGrid(const Eigen::AlignedBox3d& box) {
  Similarity3 object_from_grid;
  constexpr double kHalf = 0.5 * kModelExtent;
  if (box.min().minCoeff() >= -kHalf && box.max().maxCoeff() <= kHalf) return object_from_grid;
  object_from_grid.scale = std::max(1.0, box.sizes().maxCoeff() / kModelExtent);
  object_from_grid.translation_m = box.center();
  return object_from_grid;
}

// A grid in which what fills `box` of this one has its longest side of kModelExtent.
Similarity3 ObjectFromNextGrid(const Similarity3& object_from_grid, const VoxelBox& box) {
  const Eigen::Vector3d low = VoxelGrid::Center(box.low.x(), box.low.y(), box.low.z());
  const Eigen::Vector3d high = VoxelGrid::Center(box.high.x(), box.high.y(), box.high.z());
  // The outermost voxels are half full on average.
  const double longest = box.sides().maxCoeff() - 0.5;
  Similarity3 next = object_from_grid;
  next.scale *= longest / kModelVoxels;
  next.translation_m = object_from_grid * (0.5 * (low + high));
  return next;
}

}  // namespace

Similarity3 GridAround(const shape::ShapeModel& model,
                       std::span<const PlacedView> views,
                       double reach) {
  const Eigen::AlignedBox3d box = Around(model, PointsNear(model, views, reach));
  return OnFloor(ObjectFromGrid(box), model.bottom());
}

Similarity3 GridOver(const VoxelBox& box, const Similarity3& object_from_grid, double floor_z) {
  return OnFloor(ObjectFromNextGrid(object_from_grid, box), floor_z);
}

bool IsOfModelSize(const VoxelBox& box) { return box.sides().maxCoeff() == kModelVoxels; }

}  // namespace deepslam::refine
