#include "deepslam/refine/grid_around.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "deepslam/core/order_statistics.h"
#include "deepslam/core/parallel.h"
#include "deepslam/geometry/plane.h"
#include "deepslam/geometry/top_layer.h"

namespace deepslam::refine {
namespace {

constexpr int kPixelStep = 3;            // of views whose points bound the grid
constexpr std::size_t kOutermost = 100;  // part of these points at either end that may be noise
// Of an object's points; of an upright face a sixtieth lies in half a voxel.
constexpr double kLevelShare = 0.2;
constexpr int kFitRounds = 3;  // of choosing the points near the plane and fitting it to them
constexpr double kMostSlope = 0.035;  // 2 degrees: furniture stands plumb
constexpr int kModelVoxels = 62;      // a layer at either end stays free
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

// The same along its own z, so that a layer begins at `p`.
Similarity3 BeginningAt(Similarity3 object_from_grid, const Eigen::Vector3d& p) {
  const Eigen::Vector3d up = object_from_grid.rotation * Eigen::Vector3d::UnitZ();
  const double voxel = object_from_grid.scale * kVoxelSize;
  const double layers = up.dot(p - object_from_grid.translation_m) / voxel;
  object_from_grid.translation_m += (layers - std::round(layers)) * voxel * up;
  return object_from_grid;
}

// The height about which most of the points lie within a quarter of a voxel, where those are a
// share that nothing but a level face has.
std::optional<double> HeightOfLevelFace(const Points& points, double voxel) {
  std::vector<double> heights(points.size());
  std::ranges::transform(points, heights.begin(), [](const Eigen::Vector3d& p) { return p.z(); });
  std::ranges::sort(heights);
  const std::span<const double> face = FullestLayer(heights, 0.5 * voxel);
  if (static_cast<double>(face.size()) <= kLevelShare * static_cast<double>(heights.size()))
    return std::nullopt;
  return face[face.size() / 2];
}

// z = at.x + at.y x + at.z y.
double HeightOn(const Eigen::Vector3d& at, const Eigen::Vector3d& p) {
  return at.dot(Eigen::Vector3d(1, p.x(), p.y()));
}

// The level face as a plane, as HeightOn has it.
std::optional<Eigen::Vector3d> LevelFace(const Points& points, double voxel) {
  const std::optional<double> height = HeightOfLevelFace(points, voxel);
  if (!height) return std::nullopt;
  Eigen::Vector3d plane(*height, 0, 0);
  for (int round = 0; round < kFitRounds; ++round) {
    Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : points) {
      if (std::abs(p.z() - HeightOn(plane, p)) > voxel) continue;
      const Eigen::Vector3d row(1, p.x(), p.y());
      normal_matrix += row * row.transpose();
      right += p.z() * row;
    }
    const Eigen::Vector3d fitted = normal_matrix.ldlt().solve(right);
    if (!fitted.allFinite() || fitted.tail<2>().norm() > kMostSlope) break;
    plane = fitted;
  }
  return plane;
}

// A layer ends at the level face, so that rays that see the face at any angle find it in that layer
// and, where it is a little uneven, in no other. Without one, a layer begins at the floor.
Similarity3 OnLayers(Similarity3 object_from_grid,
                     const ThingInViews& thing,
                     const Points& points) {
  const double voxel = object_from_grid.scale * kVoxelSize;
  object_from_grid.rotation.setIdentity();
  const std::optional<Eigen::Vector3d> face =
      thing.follow_level_face ? LevelFace(points, voxel) : std::nullopt;
  if (!face) return OnFloor(object_from_grid, thing.model.bottom());
  const Eigen::Vector3d up = Eigen::Vector3d(-face->y(), -face->z(), 1).normalized();
  object_from_grid.rotation = ShortestRotation(Eigen::Vector3d::UnitZ(), up);
  return BeginningAt(object_from_grid, Eigen::Vector3d(0, 0, face->x()));
}

// The model's own grid where the box fits into it; else one that holds the box.
Similarity3 ObjectFromGrid(const Eigen::AlignedBox3d& box) {
  Similarity3 object_from_grid;
  constexpr double kHalfExtent =
      0.5 * kModelExtent;  // how far a model reaches from the cube's centre
  if (box.min().minCoeff() >= -kHalfExtent && box.max().maxCoeff() <= kHalfExtent)
    return object_from_grid;
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

Similarity3 GridAround(const ThingInViews& thing) {
  const Points points = PointsNear(thing.model, thing.views, thing.reach);
  return OnLayers(ObjectFromGrid(Around(thing.model, points)), thing, points);
}

Similarity3 GridOver(const VoxelBox& box,
                     const Similarity3& object_from_grid,
                     const ThingInViews& thing) {
  const Points points =
      thing.follow_level_face ? PointsNear(thing.model, thing.views, thing.reach) : Points();
  return OnLayers(ObjectFromNextGrid(object_from_grid, box), thing, points);
}

bool IsOfModelSize(const VoxelBox& box) { return box.sides().maxCoeff() == kModelVoxels; }

}  // namespace deepslam::refine
