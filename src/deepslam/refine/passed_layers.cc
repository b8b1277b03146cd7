#include "deepslam/refine/passed_layers.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <optional>
#include <vector>

namespace deepslam::refine {
namespace {

constexpr double kPassedShare = 0.65;   // of a part's edge that was seen
constexpr double kSeenEdgeShare = 0.1;  // of its whole edge, passed; less may be a gap of its own
constexpr double kSeenOfLeg = 0.5;      // likewise, of a leg
constexpr double kLegShare = 0.1;       // of the model's box from above; what is wider is no leg
// Rays past the outer side of a voxel, for each one that found surface in it: at an edge that
// rays graze, a misplaced view or two measure what all others look past.
constexpr double kFreeAgainstSurface = 2.5;

using Cells = std::vector<std::uint8_t>;  // index order of VoxelGrid; 0 or 1
using Cell = Eigen::Array2i;              // of a layer
const std::array<Cell, 4> kSteps = {Cell(1, 0), Cell(-1, 0), Cell(0, 1), Cell(0, -1)};

// The votes of a model's voxels.
class Layers {
 public:
  Layers(const VoxelGrid& model, std::span<const Votes> votes, std::size_t num_views)
      : model_(model), votes_(votes), num_views_(num_views), below_(votes.size(), 0) {
    for (int i = 0; i < kGridSize; ++i) {
      for (int j = 0; j < kGridSize; ++j) FindBelow(i, j);
    }
  }

  [[nodiscard]] bool IsHidden(std::size_t n) const {
    return model_.occupied[n] != 0 && !votes_[n].IsFree() && !votes_[n].HasSurface(num_views_);
  }

  // Whether the voxel at `step` from a hidden one in layer k was passed below a surface.
  [[nodiscard]] bool IsPassed(const Cell& cell, const Cell& step, int k) const {
    const std::size_t n = VoxelGrid::Index(cell.x(), cell.y(), k);
    if (below_[n] == 0) return false;
    return votes_[n].IsFree() || IsGrazed(n, cell + step, k);
  }

  [[nodiscard]] bool IsSurface(const Cell& cell, int k) const {
    return votes_[VoxelGrid::Index(cell.x(), cell.y(), k)].HasSurface(num_views_);
  }

 private:
  // Marks what of a column lies below a surface, or below a hidden voxel that rays passed above.
  void FindBelow(int i, int j) {
    bool is_below = false;
    bool is_below_passed = false;
    for (int k = kGridSize - 1; k >= 0; --k) {
      const std::size_t n = VoxelGrid::Index(i, j, k);
      below_[n] = is_below ? 1 : 0;
      is_below = is_below || votes_[n].HasSurface(num_views_) || (is_below_passed && IsHidden(n));
      is_below_passed = is_below_passed || votes_[n].IsFree();
    }
  }

  [[nodiscard]] bool IsGrazed(std::size_t n, const Cell& outer, int k) const {
    if (!VoxelGrid::Contains(outer.x(), outer.y(), k)) return false;
    const Votes& beyond = votes_[VoxelGrid::Index(outer.x(), outer.y(), k)];
    return beyond.IsFree() &&
           beyond.free > kFreeAgainstSurface * (votes_[n].object + votes_[n].other);
  }

  const VoxelGrid& model_;
  std::span<const Votes> votes_;
  std::size_t num_views_;
  Cells below_;
};

struct Edge {
  int whole = 0;   // sides of voxels
  int passed = 0;  // below a surface
  int surface = 0;

  [[nodiscard]] bool IsPassed(double seen_share) const {
    return passed >= kPassedShare * (passed + surface) && passed >= seen_share * whole &&
           passed > 0;
  }
};

// Of a layer.
struct Part {
  std::vector<std::size_t> voxels;
  Edge edge;
};

// The hidden part of layer k that holds `first`; marks its voxels in `done`.
Part PartAround(const Cell& first, int k, const Layers& layers, Cells& done) {
  Part part;
  std::vector<Cell> open = {first};
  done[VoxelGrid::Index(first.x(), first.y(), k)] = 1;
  while (!open.empty()) {
    const Cell cell = open.back();
    open.pop_back();
    part.voxels.push_back(VoxelGrid::Index(cell.x(), cell.y(), k));
    for (const Cell& step : kSteps) {
      const Cell next = cell + step;
      if (!VoxelGrid::Contains(next.x(), next.y(), k)) {
        ++part.edge.whole;
        continue;
      }
      const std::size_t n = VoxelGrid::Index(next.x(), next.y(), k);
      if (layers.IsHidden(n)) {
        if (done[n] == 0) open.push_back(next);
        done[n] = 1;
        continue;
      }
      ++part.edge.whole;
      if (layers.IsPassed(next, step, k)) {
        ++part.edge.passed;
      } else if (layers.IsSurface(next, k)) {
        ++part.edge.surface;
      }
    }
  }
  return part;
}

// Whether a part is small and half of its voxels at least have one of `grid` right below.
bool IsOfLeg(const Part& part, const VoxelGrid& grid, const VoxelBox& model) {
  const Eigen::Array3i sides = model.sides();
  const auto size = static_cast<double>(part.voxels.size());
  if (size > kLegShare * sides.x() * sides.y()) return false;
  const auto num_standing =
      std::count_if(part.voxels.begin(), part.voxels.end(), [&](std::size_t n) {
        return n % kGridSize > 0 && grid.occupied[n - 1] != 0;
      });
  return 2 * static_cast<double>(num_standing) >= size;
}

}  // namespace

VoxelGrid WithoutPassedLayers(const VoxelGrid& model,
                              std::span<const Votes> votes,
                              std::size_t num_views) {
  const std::optional<VoxelBox> box = OccupiedBox(model);
  if (!box) return model;
  const Layers layers(model, votes, num_views);
  VoxelGrid thinner = model;
  Cells done(votes.size(), 0);
  for (int k = 0; k < kGridSize; ++k) {  // upwards: what is kept below may bear what is above
    for (int i = 0; i < kGridSize; ++i) {
      for (int j = 0; j < kGridSize; ++j) {
        const std::size_t n = VoxelGrid::Index(i, j, k);
        if (done[n] != 0 || !layers.IsHidden(n)) continue;
        const Part part = PartAround({i, j}, k, layers, done);
        if (!part.edge.IsPassed(IsOfLeg(part, thinner, *box) ? kSeenOfLeg : kSeenEdgeShare))
          continue;
        for (const std::size_t voxel : part.voxels) thinner.occupied[voxel] = 0;
      }
    }
  }
  return thinner;
}

}  // namespace deepslam::refine
