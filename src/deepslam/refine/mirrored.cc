#include "deepslam/refine/mirrored.h"

#include <array>
#include <cstdlib>

namespace deepslam::refine {
namespace {

constexpr int kMaxShift = 4;        // of the plane from the model's middle, half voxels
constexpr double kLikeShare = 0.9;  // of what was measured and whose opposite was seen
constexpr double kSeenShare = 0.3;  // of what was measured, its opposite seen

bool IsSurelyFree(const Votes& votes, std::size_t num_views) {
  return votes.IsFree() && votes.free >= (num_views > 1 ? 2 : 1);
}

bool IsSure(const Votes& votes, std::size_t num_views) {
  return votes.IsMeasured(num_views) || IsSurelyFree(votes, num_views);
}

// Nothing where the opposite lies outside the grid.
std::optional<std::size_t> Opposite(const MirrorPlane& plane, Eigen::Array3i at) {
  at[plane.axis] = plane.sum - at[plane.axis];
  if (!VoxelGrid::Contains(at.x(), at.y(), at.z())) return std::nullopt;
  return VoxelGrid::Index(at.x(), at.y(), at.z());
}

// Of the measured voxels of a grid.
struct Likeness {
  int measured = 0;
  int like = 0;    // their opposite was measured as well
  int unlike = 0;  // ... is free

  [[nodiscard]] bool IsMirror() const {
    const int seen = like + unlike;
    return seen > 0 && like >= kLikeShare * seen && seen >= kSeenShare * measured;
  }
};

Likeness LikenessAcross(const MirrorPlane& plane,
                        std::span<const Votes> votes,
                        std::size_t num_views) {
  Likeness likeness;
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        if (!votes[VoxelGrid::Index(i, j, k)].IsMeasured(num_views)) continue;
        ++likeness.measured;
        const std::optional<std::size_t> opposite = Opposite(plane, {i, j, k});
        if (!opposite) continue;
        if (votes[*opposite].IsMeasured(num_views)) {
          ++likeness.like;
        } else if (IsSurelyFree(votes[*opposite], num_views)) {
          ++likeness.unlike;
        }
      }
    }
  }
  return likeness;
}

}  // namespace

std::optional<MirrorPlane> FindMirrorPlane(std::span<const Votes> votes,
                                           std::size_t num_views,
                                           const VoxelBox& model,
                                           int axis) {
  const int middle = model.low[axis] + model.high[axis];
  std::optional<MirrorPlane> best;
  int best_lead = 0;
  for (int shift = 0; shift <= kMaxShift; ++shift) {  // the nearest first
    for (const int sign : {1, -1}) {
      const MirrorPlane plane = {axis, middle + sign * shift};
      const Likeness likeness = LikenessAcross(plane, votes, num_views);
      const int lead = likeness.like - likeness.unlike;
      if (!likeness.IsMirror() || lead <= best_lead) continue;
      best = plane;
      best_lead = lead;
    }
  }
  return best;
}

std::vector<Votes> WithMirrored(const MirrorPlane& plane,
                                std::span<const Votes> votes,
                                std::size_t num_views) {
  std::vector<Votes> mirrored(votes.begin(), votes.end());
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        Votes& of_voxel = mirrored[VoxelGrid::Index(i, j, k)];
        if (of_voxel.IsFree() || of_voxel.HasSurface(num_views)) continue;
        const std::optional<std::size_t> opposite = Opposite(plane, {i, j, k});
        if (opposite && IsSure(votes[*opposite], num_views)) of_voxel += votes[*opposite];
      }
    }
  }
  return mirrored;
}

}  // namespace deepslam::refine
