#include "deepslam/shape/voxelize.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "deepslam/core/wide_vectors.h"
#include "deepslam/geometry/box.h"
#include "deepslam/shape/outside_voxels.h"
#include "deepslam/shape/stretch.h"

namespace deepslam::shape {
namespace {

// Each voxel is divided into kFine^3 cells, one bit each: (a * 4 + b) * 4 + c along x, y, z.
constexpr int kFine = 4;
constexpr int kFineSize = kGridSize * kFine;
using Block = std::uint64_t;
using Blocks = std::vector<Block>;  // a block for each voxel

constexpr std::size_t kGridVoxels = std::size_t{kGridSize} * kGridSize * kGridSize;
constexpr Block kLowX = 0x000000000000FFFF;  // the cells at the voxel's lower side along x, ...
constexpr Block kLowY = 0x000F000F000F000F;
constexpr Block kLowZ = 0x1111111111111111;
constexpr int kStepX = 16;  // bits from a cell to the next along x, ...
constexpr int kStepY = 4;   // along y, ...
constexpr int kStepZ = 1;   // and along z

using Triangle = std::array<Eigen::Vector3d, 3>;

std::vector<Triangle> UsableTriangles(const TriangleMesh& mesh) {
  std::vector<Triangle> triangles;
  triangles.reserve(mesh.faces.size());
  for (const auto& face : mesh.faces) {
    Triangle triangle;
    bool usable = true;
    for (std::size_t n = 0; n < 3 && usable; ++n) {
      usable = face[n] < mesh.vertices.size() && mesh.vertices[face[n]].allFinite();
      if (usable) triangle[n] = mesh.vertices[face[n]].cast<double>();
    }
    if (usable) triangles.push_back(triangle);
  }
  return triangles;
}

// The box's own faces lie on the rim of the outermost voxels: the last one is theirs.
constexpr int kLowestCell = kFine;
constexpr int kHighestCell = kFineSize - kFine - 1;  // the layer behind it stays free as well

// What is below zero is below the lowest cell either way, so that cutting off does what floor
// would.
std::uint32_t CellAt(double fine) {
  return static_cast<std::uint32_t>(
      std::min(std::max(static_cast<int>(fine), kLowestCell), kHighestCell));
}

// The cells of `count` points along a row: begin, begin + step, ...
void MarkRow(const Eigen::Vector3d& begin, const Eigen::Vector3d& step, int count, Blocks& shell) {
  constexpr int kCellsAtOnce =
      16;  // cells found before bits are set, so that the compiler vectorises
  std::array<std::uint32_t, kCellsAtOnce> voxels;
  std::array<std::uint32_t, kCellsAtOnce> bits;
  for (int first = 0; first < count; first += kCellsAtOnce) {
    for (int n = 0; n < kCellsAtOnce; ++n) {
      const double at = first + n;
      const std::uint32_t i = CellAt(begin.x() + at * step.x());
      const std::uint32_t j = CellAt(begin.y() + at * step.y());
      const std::uint32_t k = CellAt(begin.z() + at * step.z());
      voxels[static_cast<std::size_t>(n)] =
          (i / kFine * kGridSize + j / kFine) * kGridSize + k / kFine;
      bits[static_cast<std::size_t>(n)] =
          i % kFine * kStepX + j % kFine * kStepY + k % kFine * kStepZ;
    }
    const auto used = static_cast<std::size_t>(std::min(kCellsAtOnce, count - first));
    for (std::size_t n = 0; n < used; ++n) shell[voxels[n]] |= Block{1} << bits[n];
  }
}

// Corners in turn, such that the shortest side lies between the last two.
Triangle ShortestSideLast(const Triangle& triangle) {
  const auto length = [&](std::size_t n) {
    return (triangle[(n + 1) % 3] - triangle[(n + 2) % 3]).squaredNorm();
  };
  std::size_t first = 0;
  for (std::size_t n = 1; n < 3; ++n) first = length(n) < length(first) ? n : first;
  return {triangle[first], triangle[(first + 1) % 3], triangle[(first + 2) % 3]};
}

// Samples at most 0.7 cells apart leave no hole between 6-neighbours of the shell that a
// 6-connected flood could pass.
DEEPSLAM_WIDE_VECTORS
void MarkTriangle(const Triangle& any, Blocks& shell) {
  constexpr double kSpacing = 0.45;  // cells, in either direction: 0.64 across
  const Triangle triangle = ShortestSideLast(any);
  const Eigen::Vector3d ab = triangle[1] - triangle[0];
  const Eigen::Vector3d ac = triangle[2] - triangle[0];
  const double longest = std::max(ab.norm(), ac.norm());
  const int steps = std::max(1, static_cast<int>(std::ceil(longest / kSpacing)));
  for (int a = 0; a <= steps; ++a) {
    // Rows parallel to the shortest side, each as dense as it is long.
    const double t = static_cast<double>(a) / steps;
    const Eigen::Vector3d begin = triangle[0] + t * ab;
    const Eigen::Vector3d along = t * (ac - ab);
    const int row = std::max(1, static_cast<int>(std::ceil(along.norm() / kSpacing)));
    MarkRow(begin, along / row, row + 1, shell);
  }
}

// Voxels that the rim of the cube reaches without crossing a shell voxel: gaps narrower than a
// voxel let nothing in.
VoxelRows OutsideOf(const Blocks& shell) {
  VoxelRows free(kNumVoxelRows, 0);
  for (std::size_t n = 0; n < kGridVoxels; ++n) {
    if (shell[n] == 0) free[n / kGridSize] |= std::uint64_t{1} << n % kGridSize;
  }
  return OutsideVoxels(free);
}

// All free cells of a voxel that those in `from` reach within it.
Block Flood(Block from, Block free) {
  constexpr Block kHighY = kLowY << 3 * kStepY;
  constexpr Block kHighZ = kLowZ << 3 * kStepZ;
  Block reached = from & free;
  for (Block before = 0; before != reached;) {
    before = reached;
    reached |= (reached << kStepX | reached >> kStepX) & free;
    reached |= ((reached & ~kHighY) << kStepY | (reached & ~kLowY) >> kStepY) & free;
    reached |= ((reached & ~kHighZ) << kStepZ | (reached & ~kLowZ) >> kStepZ) & free;
  }
  return reached;
}

// A neighbouring voxel, and how cells on this side of it go over into it.
struct Side {
  std::ptrdiff_t to = 0;  // in voxels
  Block low = 0;          // cells at the lower side along this axis
  int step = 0;           // bits from a cell to the next along this axis
};

constexpr std::array<Side, 3> kAxes = {{{std::ptrdiff_t{kGridSize} * kGridSize, kLowX, kStepX},
                                        {kGridSize, kLowY, kStepY},
                                        {1, kLowZ, kStepZ}}};

// Of each shell voxel, the cells that the outside reaches through the free ones.
Blocks ReachedCells(const Blocks& shell, const VoxelRows& outside) {
  Blocks reached(kGridVoxels, 0);
  std::vector<std::size_t> waiting;
  const auto is_outside = [&](std::size_t n) {
    return (outside[n / kGridSize] >> n % kGridSize & 1) != 0;
  };
  const auto enter = [&](std::size_t n, Block cells) {
    if (shell[n] == 0 || (cells & ~shell[n] & ~reached[n]) == 0) return;
    reached[n] = Flood(reached[n] | cells, ~shell[n]);
    waiting.push_back(n);
  };
  // The rim of the cube holds no shell, so neighbours are within it.
  for (std::size_t n = 0; n < kGridVoxels; ++n) {
    if (shell[n] == 0) continue;
    Block seeds = 0;
    for (const Side& side : kAxes) {
      if (is_outside(n - static_cast<std::size_t>(side.to))) seeds |= side.low;
      if (is_outside(n + static_cast<std::size_t>(side.to))) seeds |= side.low << 3 * side.step;
    }
    enter(n, seeds);
  }
  while (!waiting.empty()) {
    const std::size_t n = waiting.back();
    waiting.pop_back();
    for (const Side& side : kAxes) {
      enter(n + static_cast<std::size_t>(side.to), reached[n] >> 3 * side.step & side.low);
      enter(n - static_cast<std::size_t>(side.to), (reached[n] & side.low) << 3 * side.step);
    }
  }
  return reached;
}

VoxelGrid SolidWithin(const Blocks& shell) {
  const VoxelRows outside = OutsideOf(shell);
  const Blocks reached = ReachedCells(shell, outside);
  std::vector<float> shares(kGridVoxels, 1.0F);
  for (std::size_t n = 0; n < kGridVoxels; ++n) {
    if (shell[n] != 0)
      shares[n] = static_cast<float>(std::popcount(~reached[n])) / (kFine * kFine * kFine);
    else if ((outside[n / kGridSize] >> n % kGridSize & 1) != 0)
      shares[n] = 0;
  }
  return SolidFromShares(shares);
}

}  // namespace

Result<VoxelGrid> Voxelize(const TriangleMesh& mesh) {
  std::vector<Triangle> triangles = UsableTriangles(mesh);
  if (triangles.empty()) return InvalidInput("mesh has no usable face");
  Box3 box;
  for (const Triangle& triangle : triangles) {
    for (const Eigen::Vector3d& corner : triangle) box.Extend(corner);
  }
  const double longest = box.Size().maxCoeff();
  constexpr double kSmallest = 1e-9;  // units of the file: below, a point but for rounding
  if (!(longest > kSmallest) || !std::isfinite(longest)) {
    return InvalidInput("mesh has no extent");
  }
  const double scale = kModelExtent * kFineSize / longest;
  Blocks shell(kGridVoxels, 0);
  for (Triangle& triangle : triangles) {
    for (Eigen::Vector3d& corner : triangle) {
      corner = (scale * (corner - box.Center())).array() + 0.5 * kFineSize;
    }
    MarkTriangle(triangle, shell);
  }
  return SolidWithin(shell);
}

}  // namespace deepslam::shape
