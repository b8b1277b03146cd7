#include "deepslam/refine/complete.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <Eigen/Geometry>

#include "deepslam/core/inner_range.h"
#include "deepslam/scene/voxel_grid.h"
#include "deepslam/shape/crumbs.h"
#include "deepslam/shape/stand.h"
#include "deepslam/shape/stretch.h"

namespace deepslam::refine {
namespace {

// Of the completed model's voxels; parts may hang unconnected where thin links were not measured.
constexpr double kCrumb = 0.02;
constexpr int kMaxInside = 3;  // voxels from the side of a shell to what nobody can see in it
constexpr int kPixelStep = 3;  // of views whose points bound the grid
constexpr std::size_t kOutermost = 100;  // part of these points at either end that may be noise
constexpr float kInside =
    0.49F;                      // share of a voxel on the surface; a half would make boards thicker
constexpr int kMaxRegrids = 2;  // for a longest side of kModelExtent
constexpr int kModelVoxels = 62;
static_assert(kModelVoxels * kVoxelSize == kModelExtent);

using Points = std::vector<Eigen::Vector3d>;

// Measured points of the object within `reach` of the model, all in object units.
Points PointsNear(const shape::ShapeModel& model, std::span<const PlacedView> views, double reach) {
  Points near;
  for (const PlacedView& placed : views) {
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
  }
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

// Of the grid's voxels to the model's surface, object units, index order of VoxelGrid.
std::vector<float> DistancesTo(const shape::ShapeModel& model,
                               const Similarity3& object_from_grid) {
  std::vector<float> distances(VoxelGrid().occupied.size());
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        const Eigen::Vector3d p = object_from_grid * VoxelGrid::Center(i, j, k);
        distances[VoxelGrid::Index(i, j, k)] = model.Distance(p.cast<float>());
      }
    }
  }
  return distances;
}

std::vector<std::uint8_t> Within(double reach, std::span<const float> distances) {
  std::vector<std::uint8_t> within(distances.size());
  std::transform(distances.begin(), distances.end(), within.begin(), [&](float distance) {
    return distance <= reach ? 1 : 0;
  });
  return within;
}

// The model in a grid of that voxel size; thin parts stay connected and one voxel thin.
VoxelGrid Inside(std::span<const float> distances, double voxel) {
  std::vector<float> shares(distances.size());
  std::transform(distances.begin(), distances.end(), shares.begin(), [&](float distance) {
    return std::clamp(kInside - distance / static_cast<float>(voxel), 0.0F, 1.0F);
  });
  return shape::SolidFromShares(shares);
}

// What the views and the model say of a grid's voxels; index order of VoxelGrid.
struct Claims {
  std::vector<Votes> votes;
  std::vector<float> distances;  // to the model's surface, object units
  double reach = 0;              // of the model, object units: what is farther is of something else
  int fewest = 2;                // views that make a surface

  [[nodiscard]] bool IsFree(std::size_t n) const {
    return votes[n].free > votes[n].object + votes[n].other;
  }
  [[nodiscard]] bool IsMeasured(std::size_t n) const {
    return distances[n] <= reach && votes[n].object >= fewest && votes[n].object >= votes[n].free;
  }
};

VoxelGrid Measured(const Claims& claims) {
  VoxelGrid grid;
  for (std::size_t n = 0; n < claims.votes.size(); ++n)
    grid.occupied[n] = claims.IsMeasured(n) ? 1 : 0;
  return grid;
}

// The model without what is free and with what was measured.
VoxelGrid Filled(const VoxelGrid& model, const Claims& claims, const VoxelGrid& measured) {
  VoxelGrid filled = measured;
  for (std::size_t n = 0; n < claims.votes.size(); ++n) {
    if (model.occupied[n] != 0 && !claims.IsFree(n)) filled.occupied[n] = 1;
  }
  return filled;
}

// Whether walking from a voxel by `step` along `axis` meets a solid one before a free one.
bool MeetsSolid(
    const VoxelGrid& grid, const Claims& claims, Eigen::Array3i at, int axis, int step) {
  for (int n = 0; n < kMaxInside; ++n) {
    at[axis] += step;
    if (!VoxelGrid::Contains(at.x(), at.y(), at.z())) return false;
    const std::size_t index = VoxelGrid::Index(at.x(), at.y(), at.z());
    if (grid.occupied[index] != 0) return true;
    if (claims.IsFree(index)) return false;
  }
  return false;
}

// Legs and boards were measured as shells: what nobody can see between two of their sides is
// solid.
VoxelGrid WithInsides(const VoxelGrid& shells, const Claims& claims) {
  VoxelGrid grid = shells;
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        const std::size_t n = VoxelGrid::Index(i, j, k);
        if (shells.occupied[n] != 0 || claims.IsFree(n)) continue;
        for (int axis = 0; axis < 3 && grid.occupied[n] == 0; ++axis) {
          if (MeetsSolid(shells, claims, {i, j, k}, axis, 1) &&
              MeetsSolid(shells, claims, {i, j, k}, axis, -1))
            grid.occupied[n] = 1;
        }
      }
    }
  }
  return grid;
}

// Legs too thin to be measured are carved away where the model's stand beside them. What would hang
// above layer `highest_foot` then keeps what the model stands on.
VoxelGrid Standing(VoxelGrid grid, const VoxelGrid& model, int highest_foot) {
  const std::optional<VoxelBox> box = OccupiedBox(grid);
  if (!box || box->low.z() <= highest_foot) return grid;
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < box->low.z(); ++k)
        grid.occupied[VoxelGrid::Index(i, j, k)] = model.At(i, j, k) ? 1 : 0;
    }
  }
  return grid;
}

std::vector<PlacedView> InGrid(std::span<const PlacedView> views,
                               const Similarity3& object_from_grid) {
  std::vector<PlacedView> placed;
  for (const PlacedView& view : views)
    placed.push_back({view.view, view.camera_from_grid * object_from_grid});
  return placed;
}

// The completed model in a grid; empty where the model is.
VoxelGrid CompleteIn(const Similarity3& object_from_grid,
                     const shape::ShapeModel& model,
                     std::span<const PlacedView> views,
                     const RefineOptions& options) {
  const double scale_m = views.front().camera_from_grid.scale;
  const double voxel = object_from_grid.scale * kVoxelSize;
  Claims claims;
  claims.distances = DistancesTo(model, object_from_grid);
  claims.reach = options.reach_m / scale_m;
  const std::vector<std::uint8_t> asked =
      Within(claims.reach + kMaxInside * voxel, claims.distances);
  claims.votes = CountVotes(InGrid(views, object_from_grid), asked, options);
  claims.fewest = views.size() > 1 ? 2 : 1;

  const VoxelGrid whole = Inside(claims.distances, voxel);
  const std::optional<VoxelBox> stands_in = OccupiedBox(whole);
  if (!stands_in) return {};
  const int ground_k = stands_in->low.z();
  const auto max_gap = static_cast<int>(shape::kMaxFeetGapM / (scale_m * voxel));
  VoxelGrid measured = Measured(claims);
  shape::StandOnGround(ground_k, max_gap, measured);
  const VoxelGrid filled = WithInsides(Filled(whole, claims, measured), claims);
  return Standing(shape::WithoutCrumbs(filled, 1, kCrumb), whole, ground_k + max_gap);
}

}  // namespace

std::optional<CompletedModel> CompleteModel(const shape::ShapeModel& model,
                                            std::span<const PlacedView> all_views,
                                            const RefineOptions& options) {
  const std::vector<PlacedView> views = UsableViews(all_views);
  if (model.empty() || views.empty()) return std::nullopt;
  const double reach = options.reach_m / views.front().camera_from_grid.scale;
  Similarity3 object_from_grid =
      OnFloor(ObjectFromGrid(Around(model, PointsNear(model, views, reach))), model.bottom());
  VoxelGrid grid = CompleteIn(object_from_grid, model, views, options);
  std::optional<VoxelBox> box = OccupiedBox(grid);
  // A grid that fits is made by the views: resampled, one layer in sixty would fall out of boards.
  for (int n = 0; n < kMaxRegrids && box && box->sides().maxCoeff() != kModelVoxels; ++n) {
    object_from_grid = OnFloor(ObjectFromNextGrid(object_from_grid, *box), model.bottom());
    grid = CompleteIn(object_from_grid, model, views, options);
    box = OccupiedBox(grid);
  }
  if (!box) return std::nullopt;
  const double extent = box->sides().maxCoeff() * kVoxelSize * object_from_grid.scale;
  return CompletedModel{shape::StretchGrid(grid, Eigen::Vector3d::Ones()), extent};
}

}  // namespace deepslam::refine
