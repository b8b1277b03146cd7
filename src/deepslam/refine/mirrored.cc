#include "deepslam/refine/mirrored.h"

#include <algorithm>
#include <cstdint>

namespace deepslam::refine {
namespace {

constexpr int kMaxPlaneShift = 4;   // of the plane from the model's middle, half voxels
constexpr double kLikeShare = 0.9;  // of what was measured and whose opposite was seen
constexpr double kOppositeSeenShare = 0.3;  // of what was measured, its opposite seen

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
struct MirrorAgreement {
  int measured = 0;
  int like = 0;    // their opposite was measured as well
  int unlike = 0;  // ... is free

  [[nodiscard]] bool IsMirror() const {
    const int seen = like + unlike;
    return seen > 0 && like >= kLikeShare * seen && seen >= kOppositeSeenShare * measured;
  }
};

// A run of voxels in a column, `first` to before `last`.
struct Run {
  std::size_t first = 0;
  std::size_t last = 0;
};

// Frees the run where the other side does along half of it at least, else nothing of it.
void FreeWholeOrNot(const Run& run,
                    std::span<const Votes> seen,
                    std::size_t num_views,
                    std::vector<Votes>& votes) {
  const auto begin = votes.begin() + static_cast<std::ptrdiff_t>(run.first);
  const auto end = votes.begin() + static_cast<std::ptrdiff_t>(run.last);
  const auto num_free = std::count_if(begin, end, [](const Votes& of) { return of.IsFree(); });
  const bool is_free = 2 * num_free >= end - begin;
  for (std::size_t n = run.first; n < run.last; ++n) {
    if (votes[n].IsMeasured(num_views)) continue;
    if (is_free) {
      votes[n].free = votes[n].object + votes[n].other + 1;
    } else {
      votes[n] = seen[n];
    }
  }
}

// The votes of a grid as far as mirror images ask them.
struct Sureness {
  enum Kind : std::uint8_t { kNeither, kMeasured, kFree };

  Sureness(std::span<const Votes> votes, std::size_t num_views) : kinds(votes.size(), kNeither) {
    for (int i = 0; i < kGridSize; ++i) {
      for (int j = 0; j < kGridSize; ++j) {
        for (int k = 0; k < kGridSize; ++k) {
          const std::size_t n = VoxelGrid::Index(i, j, k);
          if (votes[n].IsMeasured(num_views)) {
            kinds[n] = kMeasured;
            measured.emplace_back(i, j, k);
          } else if (IsSurelyFree(votes[n], num_views)) {
            kinds[n] = kFree;
          }
        }
      }
    }
  }

  std::vector<Kind> kinds;  // index order of VoxelGrid
  std::vector<Eigen::Array3i> measured;
};

MirrorAgreement AgreementAcross(const MirrorPlane& plane, const Sureness& sure) {
  MirrorAgreement agreement;
  agreement.measured = static_cast<int>(sure.measured.size());
  for (const Eigen::Array3i& voxel : sure.measured) {
    const std::optional<std::size_t> opposite = Opposite(plane, voxel);
    if (!opposite) continue;
    agreement.like += sure.kinds[*opposite] == Sureness::kMeasured ? 1 : 0;
    agreement.unlike += sure.kinds[*opposite] == Sureness::kFree ? 1 : 0;
  }
  return agreement;
}

}  // namespace

std::optional<MirrorPlane> FindMirrorPlane(std::span<const Votes> votes,
                                           std::size_t num_views,
                                           const VoxelBox& model,
                                           int axis) {
  const Sureness sure(votes, num_views);
  const int middle = model.low[axis] + model.high[axis];
  std::optional<MirrorPlane> best;
  int best_margin = 0;
  for (int shift = 0; shift <= kMaxPlaneShift; ++shift) {  // the nearest first
    for (const int sign : {1, -1}) {
      const MirrorPlane plane = {axis, middle + sign * shift};
      const MirrorAgreement agreement = AgreementAcross(plane, sure);
      const int margin = agreement.like - agreement.unlike;
      if (!agreement.IsMirror() || margin <= best_margin) continue;
      best = plane;
      best_margin = margin;
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

std::vector<Votes> InWholeRuns(const VoxelGrid& model,
                               std::span<const Votes> seen,
                               std::span<const Votes> mirrored,
                               std::size_t num_views) {
  std::vector<Votes> votes(mirrored.begin(), mirrored.end());
  const auto is_open = [&](std::size_t n) {
    return model.occupied[n] != 0 && !seen[n].IsFree() && !seen[n].HasSurface(num_views);
  };
  for (std::size_t column = 0; column < votes.size(); column += kGridSize) {
    for (Run run = {column, column}; run.last < column + kGridSize;) {
      run.first = run.last;
      while (run.last < column + kGridSize && is_open(run.last)) ++run.last;
      if (run.last > run.first) {
        FreeWholeOrNot(run, seen, num_views, votes);
      } else {
        ++run.last;
      }
    }
  }
  return votes;
}

}  // namespace deepslam::refine
