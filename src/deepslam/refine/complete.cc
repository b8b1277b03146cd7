#include "deepslam/refine/complete.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "deepslam/core/parallel.h"
#include "deepslam/core/wide_vectors.h"
#include "deepslam/geometry/point_columns.h"
#include "deepslam/refine/covered_holes.h"
#include "deepslam/refine/grid_around.h"
#include "deepslam/refine/links.h"
#include "deepslam/refine/mirrored.h"
#include "deepslam/refine/passed_layers.h"
#include "deepslam/scene/voxel_grid.h"
#include "deepslam/shape/small_components.h"
#include "deepslam/shape/stand.h"
#include "deepslam/shape/stretch.h"

namespace deepslam::refine {
namespace {

// Of the completed model's voxels: larger parts are tied to the largest (links.h).
constexpr double kLoosePartShare = 0.02;
constexpr double kLongestLinkM = 0.3;       // through the model
constexpr std::uint8_t kCostOfModel = 2;    // of a voxel of a link (links.h) that the model has
constexpr std::uint8_t kCostOfUnknown = 3;  // dearer, so that links follow the model where they can
constexpr int kMaxInside = 5;  // voxels between two sides of a shell that nobody can see
// Of a thing's measured voxels: more of them behind a wall are no noise, and the wall is not its.
constexpr double kMaxBehindWall = 0.02;
// Of the model: what is for the most part behind a wall stands elsewhere, and is not too deep.
constexpr double kMaxModelBehindWall = 0.5;
constexpr int kBesideTop = 3;      // voxels beside a side of a top that tell whether it ends there
constexpr double kMostSeen = 0.5;  // of these
constexpr double kEdgeM = 0.0125;  // half a cell of the points that sides are made of
constexpr int kMaxRegrids = 2;     // for a longest side of kModelExtent
// Share of a voxel on the surface; a half would make boards thicker.
constexpr float kInsideShare = 0.49F;

// Of the voxels (i, 0, 0) to (i, 63, 63).
DEEPSLAM_WIDE_VECTORS void DistancesInSlice(const shape::ShapeModel& model,
                                            const SimilarityMatrix& object_from_grid,
                                            int i,
                                            float* distances) {
  VectorColumns points;
  shape::FieldSampleColumns samples;
  for (int j = 0; j < kGridSize; ++j) {
    for (int k = 0; k < kGridSize; ++k) {
      const Eigen::Vector3f p = (object_from_grid * VoxelGrid::Center(i, j, k)).cast<float>();
      points.Set(static_cast<std::size_t>(k), p.x(), p.y(), p.z());
    }
    model.At(points, kGridSize, samples);
    std::copy_n(samples.distance.begin(), kGridSize, distances + j * kGridSize);
  }
}

// Of the grid's voxels to the model's surface, object units, index order of VoxelGrid.
std::vector<float> DistancesTo(const shape::ShapeModel& model,
                               const Similarity3& object_from_grid) {
  static_assert(kGridSize <= kPointBatch && kGridSize % kPointLanes == 0);
  std::vector<float> distances(VoxelGrid().occupied.size());
  const SimilarityMatrix map(object_from_grid);
  ParallelFor(kGridSize, [&](std::size_t i) {
    DistancesInSlice(model, map, static_cast<int>(i), distances.data() + i * kGridSize * kGridSize);
  });
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
    return std::clamp(kInsideShare - distance / static_cast<float>(voxel), 0.0F, 1.0F);
  });
  return shape::SolidFromShares(shares);
}

// What the views and the model say of a grid's voxels; index order of VoxelGrid.
struct Claims {
  std::vector<Votes> seen;
  std::vector<Votes> votes;      // what was seen, and on the other side where nothing was
  std::vector<float> distances;  // to the model's surface, object units
  double reach = 0;              // of the model, object units: what is farther is of something else
  double voxel = 0;              // object units
  std::size_t num_views = 0;

  [[nodiscard]] bool IsFree(std::size_t n) const { return votes[n].IsFree(); }
  // The other side adds parts that the model lacks; its noise makes no surface of the model uneven.
  [[nodiscard]] bool IsMeasured(std::size_t n) const {
    return distances[n] <= reach && (distances[n] > voxel ? votes : seen)[n].IsMeasured(num_views);
  }
};

// Across y the left and right, across x the front and back.
std::vector<Votes> WithMirrorImages(const VoxelGrid& model,
                                    const VoxelBox& box,
                                    const std::vector<Votes>& seen,
                                    std::size_t num_views) {
  std::vector<Votes> votes = seen;
  for (const int axis : {1, 0}) {
    const std::optional<MirrorPlane> plane = FindMirrorPlane(votes, num_views, box, axis);
    if (plane) votes = WithMirrored(*plane, votes, num_views);
  }
  return InWholeRuns(model, seen, votes, num_views);
}

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

// Steps from a voxel along `axis` to a solid one; none where a free one comes first.
std::optional<int> StepsToSolid(
    const VoxelGrid& grid, const Claims& claims, Eigen::Array3i at, int axis, int step) {
  for (int n = 1; n <= kMaxInside; ++n) {
    at[axis] += step;
    if (!VoxelGrid::Contains(at.x(), at.y(), at.z())) return std::nullopt;
    const std::size_t index = VoxelGrid::Index(at.x(), at.y(), at.z());
    if (grid.occupied[index] != 0) return n;
    if (claims.IsFree(index)) return std::nullopt;
  }
  return std::nullopt;
}

// Whether a voxel lies in a gap of at most kMaxInside voxels: all of it is filled, or nothing.
bool IsBetweenSides(const VoxelGrid& grid,
                    const Claims& claims,
                    const Eigen::Array3i& at,
                    int axis) {
  const std::optional<int> up = StepsToSolid(grid, claims, at, axis, 1);
  const std::optional<int> down = up ? StepsToSolid(grid, claims, at, axis, -1) : std::nullopt;
  return down && *up + *down - 1 <= kMaxInside;
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
          if (IsBetweenSides(shells, claims, {i, j, k}, axis)) grid.occupied[n] = 1;
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

// Links cost a step where the model is or nothing is known; nothing goes where rays went and the
// model is not.
std::vector<std::uint8_t> CostsOfLinks(const VoxelGrid& model, const Claims& claims) {
  std::vector<std::uint8_t> costs(claims.votes.size());
  for (std::size_t n = 0; n < costs.size(); ++n) {
    if (model.occupied[n] != 0) {
      costs[n] = kCostOfModel;
    } else {
      costs[n] = claims.IsFree(n) ? 0 : kCostOfUnknown;
    }
  }
  return costs;
}

std::vector<PlacedView> InGrid(std::span<const PlacedView> views,
                               const Similarity3& object_from_grid) {
  std::vector<PlacedView> placed;
  for (const PlacedView& view : views)
    placed.push_back({view.view, view.camera_from_grid * object_from_grid});
  return placed;
}

// One entry per voxel, index order of VoxelGrid: whether it lies behind the plane.
std::vector<std::uint8_t> Behind(const Plane& plane, const Similarity3& object_from_grid) {
  std::vector<std::uint8_t> behind(VoxelGrid().occupied.size());
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        const Eigen::Vector3d p = object_from_grid * VoxelGrid::Center(i, j, k);
        behind[VoxelGrid::Index(i, j, k)] = plane.SignedDistance(p) < 0 ? 1 : 0;
      }
    }
  }
  return behind;
}

bool IsMeasuredBehind(std::span<const std::uint8_t> behind, const Claims& claims) {
  std::size_t num_measured = 0;
  std::size_t num_behind = 0;
  for (std::size_t n = 0; n < behind.size(); ++n) {
    if (!claims.seen[n].IsMeasured(claims.num_views)) continue;
    ++num_measured;
    num_behind += behind[n];
  }
  return static_cast<double>(num_behind) > kMaxBehindWall * static_cast<double>(num_measured);
}

bool IsMostlyBehind(std::span<const std::uint8_t> behind, const VoxelGrid& model) {
  std::size_t num_voxels = 0;
  std::size_t num_behind = 0;
  for (std::size_t n = 0; n < behind.size(); ++n) {
    if (model.occupied[n] == 0) continue;
    ++num_voxels;
    num_behind += behind[n];
  }
  return static_cast<double>(num_behind) > kMaxModelBehindWall * static_cast<double>(num_voxels);
}

// Claims that nothing is there.
void Clear(std::size_t n, Claims& claims) {
  constexpr Votes kFree{.free = 1};
  claims.seen[n] = claims.votes[n] = kFree;
}

// Claims that nothing is behind the walls.
void EndAtWalls(std::span<const Plane> walls,
                const Similarity3& object_from_grid,
                const VoxelGrid& model,
                Claims& claims) {
  for (const Plane& wall : walls) {
    const std::vector<std::uint8_t> behind = Behind(wall, object_from_grid);
    if (IsMeasuredBehind(behind, claims) || IsMostlyBehind(behind, model)) continue;
    for (std::size_t n = 0; n < behind.size(); ++n) {
      if (behind[n] != 0) Clear(n, claims);
    }
  }
}

// Whether most of what lies beside a side of the top was seen, at its height: had it been the top,
// the side would lie farther out.
bool IsSeenToEnd(const Plane& side,
                 const Limits& limits,
                 const Similarity3& object_from_grid,
                 const Claims& claims) {
  const auto is_beside = [&](const Eigen::Vector3d& p) {
    const double below = limits.top->SignedDistance(p);
    const double beyond = -side.SignedDistance(p);
    const double reach = kBesideTop * claims.voxel;
    return below >= 0 && below < claims.voxel && beyond >= 0 && beyond < reach &&
           std::ranges::count_if(
               limits.sides, [&](const Plane& other) { return other.SignedDistance(p) < 0; }) == 1;
  };
  int num_voxels = 0;
  int num_seen = 0;
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        if (!is_beside(object_from_grid * VoxelGrid::Center(i, j, k))) continue;
        const Votes& votes = claims.seen[VoxelGrid::Index(i, j, k)];
        ++num_voxels;
        num_seen += votes.free + votes.object + votes.other > 0 ? 1 : 0;
      }
    }
  }
  return num_seen > kMostSeen * num_voxels;
}

// Claims that the model ends with its top.
void EndWithTop(const Limits& limits,
                const Similarity3& object_from_grid,
                double scale_m,
                Claims& claims) {
  if (!limits.top) return;
  for (const Plane& side : limits.sides) {
    if (!IsSeenToEnd(side, limits, object_from_grid, claims)) continue;
    Plane reach = side;
    reach.d_m += kEdgeM / scale_m;
    const std::vector<std::uint8_t> beyond = Behind(reach, object_from_grid);
    for (std::size_t n = 0; n < beyond.size(); ++n) {
      if (beyond[n] != 0) Clear(n, claims);
    }
  }
}

// What is known of the object beside the model.
struct Knowledge {
  std::span<const PlacedView> views;
  const Limits& limits;
};

// Surface beyond the sides is no longer the object's.
void EndAtSides(const Limits& limits,
                const Similarity3& object_from_grid,
                std::vector<Votes>& seen) {
  std::vector<Plane> sides = limits.sides;
  if (limits.top) sides.push_back(*limits.top);
  for (const Plane& side : sides) {
    const std::vector<std::uint8_t> beyond = Behind(side, object_from_grid);
    for (std::size_t n = 0; n < seen.size(); ++n) {
      if (beyond[n] == 0) continue;
      seen[n].other += seen[n].object;
      seen[n].object = 0;
    }
  }
}

// The completed model in a grid; empty where the model is.
VoxelGrid CompleteIn(const Similarity3& object_from_grid,
                     const shape::ShapeModel& model,
                     const Knowledge& known,
                     const RefineOptions& options) {
  const std::span<const PlacedView> views = known.views;
  const double scale_m = views.front().camera_from_grid.scale;
  const double voxel = object_from_grid.scale * kVoxelSize;
  Claims claims;
  claims.distances = DistancesTo(model, object_from_grid);
  claims.reach = options.reach_m / scale_m;
  const std::vector<std::uint8_t> asked =
      Within(claims.reach + kMaxInside * voxel, claims.distances);
  claims.seen = CountVotes(InGrid(views, object_from_grid), asked);
  EndAtSides(known.limits, object_from_grid, claims.seen);
  claims.voxel = voxel;
  claims.num_views = views.size();

  const VoxelGrid inside = Inside(claims.distances, voxel);
  const std::optional<VoxelBox> stands_in = OccupiedBox(inside);
  if (!stands_in) return {};
  const VoxelGrid whole = WithoutPassedLayers(inside, claims.seen, claims.num_views);
  claims.votes = WithMirrorImages(whole, *stands_in, claims.seen, claims.num_views);
  EndWithTop(known.limits, object_from_grid, scale_m, claims);
  EndAtWalls(known.limits.walls, object_from_grid, whole, claims);
  const int ground_k = stands_in->low.z();
  const auto max_gap = static_cast<int>(shape::kMaxFeetGapM / (scale_m * voxel));
  VoxelGrid measured = Measured(claims);
  shape::StandOnGround(ground_k, max_gap, measured);
  VoxelGrid filled = WithInsides(Filled(whole, claims, measured), claims);
  FillCoveredHoles([&](std::size_t n) { return claims.IsFree(n); }, filled);
  const VoxelGrid standing = Standing(
      shape::WithoutSmallComponents(filled, 1, kLoosePartShare), whole, ground_k + max_gap);
  const auto most = static_cast<int>(kCostOfModel * kLongestLinkM / (scale_m * voxel));
  return WithLinks(standing, whole, CostsOfLinks(whole, claims), most);
}

}  // namespace

std::optional<CompletedModel> CompleteModel(const shape::ShapeModel& model,
                                            std::span<const PlacedView> all_views,
                                            const RefineOptions& options,
                                            const Limits& limits) {
  const std::vector<PlacedView> views = UsableViews(all_views);
  if (model.empty() || views.empty()) return std::nullopt;
  const double reach = options.reach_m / views.front().camera_from_grid.scale;
  const ThingInViews thing{model, views, reach, options.follow_level_face};
  Similarity3 object_from_grid = GridAround(thing);
  const Knowledge known{views, limits};
  VoxelGrid grid = CompleteIn(object_from_grid, model, known, options);
  std::optional<VoxelBox> box = OccupiedBox(grid);
  // A grid that fits is made by the views: resampled, one layer in sixty would fall out of boards.
  for (int n = 0; n < kMaxRegrids && box && !IsOfModelSize(*box); ++n) {
    object_from_grid = GridOver(*box, object_from_grid, thing);
    grid = CompleteIn(object_from_grid, model, known, options);
    box = OccupiedBox(grid);
  }
  if (!box) return std::nullopt;
  return CompletedModel{shape::StretchGrid(grid, Eigen::Vector3d::Ones()),
                        object_from_grid * shape::GridFromCentred(*box)};
}

}  // namespace deepslam::refine
