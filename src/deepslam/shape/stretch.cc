#include "deepslam/shape/stretch.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

namespace deepslam::shape {
namespace {

// A voxel and its 26 neighbours, a bit each: (di + 1) * 9 + (dj + 1) * 3 + (dk + 1).
using Neighbourhood = std::uint32_t;
constexpr int kBlockCells = 27;  // 3 x 3 x 3
constexpr Neighbourhood kCentre = 1U << 13;

// How many coordinates of two cells differ, and by how much at most.
struct Apart {
  int sum = 0;
  int most = 0;
};

constexpr Apart ApartOf(int m, int n) {
  Apart apart;
  for (const int place : {1, 3, 9}) {
    const int d = m / place % 3 - n / place % 3;
    apart.sum += d < 0 ? -d : d;
    apart.most = std::max(apart.most, d < 0 ? -d : d);
  }
  return apart;
}

// Of each cell, those that share a face with it; with `corners`, also an edge or a corner.
constexpr std::array<Neighbourhood, kBlockCells> Touching(bool corners) {
  std::array<Neighbourhood, kBlockCells> touching{};
  for (int m = 0; m < kBlockCells; ++m) {
    for (int n = 0; n < kBlockCells; ++n) {
      const Apart apart = ApartOf(m, n);
      if (corners ? apart.most == 1 : apart.sum == 1)
        touching[static_cast<std::size_t>(m)] |= 1U << n;
    }
  }
  return touching;
}

constexpr std::array<Neighbourhood, kBlockCells> kTouching26 = Touching(true);
constexpr std::array<Neighbourhood, kBlockCells> kTouching6 = Touching(false);
constexpr Neighbourhood kFaceNeighbours = kTouching6[13];
constexpr Neighbourhood kEdgeNeighbours = [] {
  Neighbourhood near = 0;
  for (int n = 0; n < kBlockCells; ++n) near |= ApartOf(n, 13).sum <= 2 ? 1U << n : 0U;
  return near & ~kCentre;
}();

Neighbourhood Around(const VoxelGrid& grid, int i, int j, int k) {
  Neighbourhood solid = 0;
  int n = 0;
  for (int di = -1; di <= 1; ++di) {
    for (int dj = -1; dj <= 1; ++dj) {
      for (int dk = -1; dk <= 1; ++dk, ++n) {
        if (VoxelGrid::Contains(i + di, j + dj, k + dk) && grid.At(i + di, j + dj, k + dk))
          solid |= 1U << n;
      }
    }
  }
  return solid;
}

// Connected components of `cells` that hold one of `seeds`.
int NumComponents(Neighbourhood cells,
                  Neighbourhood seeds,
                  const std::array<Neighbourhood, kBlockCells>& touching) {
  int count = 0;
  for (seeds &= cells; seeds != 0; seeds &= cells) {
    ++count;
    Neighbourhood waiting = seeds & (~seeds + 1);  // the lowest bit
    while (waiting != 0) {
      cells &= ~waiting;
      Neighbourhood next = 0;
      for (; waiting != 0; waiting &= waiting - 1)
        next |= touching[static_cast<std::size_t>(std::countr_zero(waiting))];
      waiting = next & cells;
    }
  }
  return count;
}

// Whether taking the voxel away changes no connection of solid (by faces, edges and corners) or of
// free space (by faces, among those that share a face or an edge with it): a simple point.
bool IsSimple(const VoxelGrid& grid, int i, int j, int k) {
  const Neighbourhood solid = Around(grid, i, j, k);
  return NumComponents(solid & ~kCentre, ~kCentre, kTouching26) == 1 &&
         NumComponents(~solid & kEdgeNeighbours, kFaceNeighbours, kTouching6) == 1;
}

struct Voxel {
  float share;
  std::array<int, 3> at;
};

// A face neighbour that can stand for a voxel about to be taken away: fuller, or as full and
// already standing for others. Without the second rule a thin bar would be eaten from its end.
std::optional<std::size_t> Stand(const VoxelGrid& grid,
                                 const std::vector<float>& shares,
                                 const std::vector<std::uint8_t>& fixed,
                                 const Voxel& voxel) {
  constexpr std::array<std::array<int, 3>, 6> kFaces = {
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};
  std::optional<std::size_t> best;
  for (const auto& face : kFaces) {
    const int i = voxel.at[0] + face[0];
    const int j = voxel.at[1] + face[1];
    const int k = voxel.at[2] + face[2];
    if (!VoxelGrid::Contains(i, j, k) || !grid.At(i, j, k)) continue;
    const std::size_t n = VoxelGrid::Index(i, j, k);
    if (fixed[n] == 0 && shares[n] < voxel.share) continue;
    if (!best || shares[n] > shares[*best]) best = n;
  }
  return best;
}

// Where a line of voxels comes to lie.
struct AxisMap {
  double factor = 1;  // target voxels per source voxel
  double shift = 0;   // target coordinate of source coordinate 0, voxels
};

// What StretchGrid does to a box, along each axis.
std::array<AxisMap, 3> CentringOf(const VoxelBox& box, const Eigen::Vector3d& factors) {
  const Eigen::Array3d sides = box.sides().cast<double>();
  const double longest = (sides * factors.array()).maxCoeff();
  std::array<AxisMap, 3> maps;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto n = static_cast<Eigen::Index>(axis);
    const double factor = factors[n] * (static_cast<double>(kGridSize) * kModelExtent / longest);
    const double low = box.low[n];
    // Off centre by half a voxel at most, so that the lower face falls on voxel borders and stays
    // sharp.
    const double ideal = 0.5 * (kGridSize - factor * sides[n]);
    const bool keeps = std::abs(factor - 1.0) < 1e-9 && std::abs(ideal - low) <= 0.5;
    maps[axis] = {factor, (keeps ? low : std::round(ideal)) - factor * low};
  }
  return maps;
}

// The share of target voxel `to` that source voxel `from` covers.
struct Cover {
  std::size_t from = 0;
  std::size_t to = 0;
  float weight = 0;
};

std::vector<Cover> Covers(const AxisMap& map) {
  std::vector<Cover> covers;
  for (int from = 0; from < kGridSize; ++from) {
    const double begin = map.shift + map.factor * from;
    const double end = begin + map.factor;
    const int first = std::clamp(static_cast<int>(std::floor(begin)), 0, kGridSize);
    const int last = std::clamp(static_cast<int>(std::ceil(end)), 0, kGridSize);
    for (int to = first; to < last; ++to) {
      const auto weight = static_cast<float>(std::min(end, to + 1.0) - std::max<double>(begin, to));
      if (weight > 0)
        covers.push_back({static_cast<std::size_t>(from), static_cast<std::size_t>(to), weight});
    }
  }
  return covers;
}

// Along the axis whose neighbours lie `stride` apart; rows of `stride` values are taken as one.
std::vector<float> ResampleAxis(const std::vector<float>& source,
                                std::size_t stride,
                                const AxisMap& map) {
  const std::vector<Cover> covers = Covers(map);
  std::vector<float> target(source.size(), 0.0F);
  const std::size_t slab = stride * kGridSize;
  for (std::size_t first = 0; first < source.size(); first += slab) {
    for (const Cover& cover : covers) {
      const float* const from = source.data() + first + cover.from * stride;
      float* const to = target.data() + first + cover.to * stride;
      for (std::size_t n = 0; n < stride; ++n) to[n] += cover.weight * from[n];
    }
  }
  return target;
}

}  // namespace

VoxelGrid SolidFromShares(const std::vector<float>& shares) {
  // Sums of shares of exactly one half must not depend on rounding.
  constexpr float kHalf = 0.5F - 1e-4F;
  constexpr float kSomething = 1e-3F;  // smaller sums of shares are rounding
  VoxelGrid grid;
  std::vector<std::uint8_t> fixed(shares.size(), 0);
  std::vector<Voxel> partly;
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        const std::size_t n = VoxelGrid::Index(i, j, k);
        grid.occupied[n] = shares[n] > kSomething ? 1 : 0;
        fixed[n] = shares[n] >= kHalf ? 1 : 0;
        if (grid.occupied[n] != 0 && fixed[n] == 0) partly.push_back({shares[n], {i, j, k}});
      }
    }
  }
  std::stable_sort(partly.begin(), partly.end(), [](const Voxel& a, const Voxel& b) {
    return a.share < b.share;
  });
  for (const Voxel& voxel : partly) {
    const std::size_t n = VoxelGrid::Index(voxel.at[0], voxel.at[1], voxel.at[2]);
    if (fixed[n] != 0) continue;
    const std::optional<std::size_t> stand = Stand(grid, shares, fixed, voxel);
    if (!stand || !IsSimple(grid, voxel.at[0], voxel.at[1], voxel.at[2])) continue;
    grid.occupied[n] = 0;
    fixed[*stand] = 1;
  }
  return grid;
}

VoxelGrid StretchGrid(const VoxelGrid& grid, const Eigen::Vector3d& factors) {
  const std::optional<VoxelBox> box = OccupiedBox(grid);
  if (!box || !(factors.array() > 0).all() || !factors.allFinite()) return grid;
  const std::array<AxisMap, 3> maps = CentringOf(*box, factors);
  std::vector<float> shares(grid.occupied.begin(), grid.occupied.end());
  constexpr std::array<std::size_t, 3> kStride = {kGridSize * kGridSize, kGridSize, 1};
  for (std::size_t axis = 0; axis < 3; ++axis)
    shares = ResampleAxis(shares, kStride[axis], maps[axis]);
  return SolidFromShares(shares);
}

Similarity3 GridFromCentred(const VoxelBox& box) {
  const std::array<AxisMap, 3> maps = CentringOf(box, Eigen::Vector3d::Ones());
  const double scale = 1 / maps[0].factor;
  const Eigen::Array3d shift(maps[0].shift, maps[1].shift, maps[2].shift);
  const Eigen::Array3d origin = scale * (0.5 * kGridSize - shift);  // voxels of the grid
  return {scale, Eigen::Quaterniond::Identity(), (kVoxelSize * origin - 0.5).matrix()};
}

VoxelGrid TurnGrid(const VoxelGrid& grid, int quarter_turns) {
  const int turns = ((quarter_turns % 4) + 4) % 4;
  VoxelGrid turned;
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      int x = i;
      int y = j;
      for (int n = 0; n < turns; ++n) x = std::exchange(y, x) * -1 + kGridSize - 1;
      for (int k = 0; k < kGridSize; ++k) {
        turned.occupied[VoxelGrid::Index(x, y, k)] = grid.occupied[VoxelGrid::Index(i, j, k)];
      }
    }
  }
  return turned;
}

double GridIntersectionOverUnion(const VoxelGrid& a, const VoxelGrid& b) {
  std::size_t common = 0;
  std::size_t either = 0;
  for (std::size_t n = 0; n < a.occupied.size(); ++n) {
    const bool in_a = a.occupied[n] != 0;
    const bool in_b = b.occupied[n] != 0;
    common += in_a && in_b ? 1U : 0U;
    either += in_a || in_b ? 1U : 0U;
  }
  return either > 0 ? static_cast<double>(common) / static_cast<double>(either) : 0.0;
}

}  // namespace deepslam::shape
