#include "deepslam/shape/voxelize.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "deepslam/geometry/box.h"
#include "deepslam/shape/stretch.h"

namespace deepslam::shape {
namespace {

// Fine raster: kFine cells per voxel edge.
constexpr int kFine = 4;
constexpr int kFineSize = kGridSize * kFine;
using Cells = std::vector<std::uint8_t>;

constexpr std::uint8_t kFree = 0;
constexpr std::uint8_t kShell = 1;
constexpr std::uint8_t kOutside = 2;

std::size_t FineIndex(int i, int j, int k) {
  return (static_cast<std::size_t>(i) * kFineSize + static_cast<std::size_t>(j)) * kFineSize +
         static_cast<std::size_t>(k);
}

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

void MarkPoint(const Eigen::Vector3d& p_fine, Cells& cells) {
  // The box's own faces lie on the rim of the outermost voxels: the last one is theirs.
  constexpr int kLow = kFine;
  constexpr int kHigh = kFineSize - kFine - 1;
  // What is below zero is below kLow either way, so that cutting off does what floor would.
  const auto cell = [&](double x) { return std::clamp(static_cast<int>(x), kLow, kHigh); };
  cells[FineIndex(cell(p_fine.x()), cell(p_fine.y()), cell(p_fine.z()))] = kShell;
}

// Samples at most 0.7 cells apart leave no hole between 6-neighbours of the shell that a
// 6-connected flood could pass.
void MarkTriangle(const Triangle& triangle, Cells& cells) {
  constexpr double kSpacing = 0.45;
  const Eigen::Vector3d ab = triangle[1] - triangle[0];
  const Eigen::Vector3d ac = triangle[2] - triangle[0];
  const double longest = std::max({ab.norm(), ac.norm(), (triangle[2] - triangle[1]).norm()});
  const int steps = std::max(1, static_cast<int>(std::ceil(longest / kSpacing)));
  for (int a = 0; a <= steps; ++a) {
    // Rows parallel to the side from corner 1 to corner 2, each as dense as it is long.
    const double t = static_cast<double>(a) / steps;
    const Eigen::Vector3d begin = triangle[0] + t * ab;
    const Eigen::Vector3d along = t * (ac - ab);
    const int row = std::max(1, static_cast<int>(std::ceil(along.norm() / kSpacing)));
    const Eigen::Vector3d step = along / row;
    for (int b = 0; b <= row; ++b) MarkPoint(begin + static_cast<double>(b) * step, cells);
  }
}

constexpr std::array<std::array<int, 3>, 6> kFaces = {
    {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};

// Voxels with any shell in them. Cells are free or shell yet: a row of them is looked at as one
// number.
VoxelGrid ShellVoxels(const Cells& cells) {
  static_assert(kFine == sizeof(std::uint32_t));
  VoxelGrid shell;
  for (int i = 0; i < kFineSize; ++i) {
    for (int j = 0; j < kFineSize; ++j) {
      const std::uint8_t* line = cells.data() + FineIndex(i, j, 0);
      std::uint8_t* out = shell.occupied.data() + VoxelGrid::Index(i / kFine, j / kFine, 0);
      for (int k = 0; k < kGridSize; ++k, line += kFine, ++out) {
        std::uint32_t row = 0;
        std::memcpy(&row, line, sizeof(row));
        if (row != 0) *out = 1;
      }
    }
  }
  return shell;
}

// Voxels that the rim of the cube reaches without crossing a shell voxel: gaps narrower than a
// voxel let nothing in.
VoxelGrid OutsideVoxels(const VoxelGrid& shell) {
  VoxelGrid outside;
  std::vector<std::array<int, 3>> stack = {{0, 0, 0}};
  outside.occupied[0] = 1;
  while (!stack.empty()) {
    const std::array<int, 3> at = stack.back();
    stack.pop_back();
    for (const auto& face : kFaces) {
      const std::array<int, 3> next = {at[0] + face[0], at[1] + face[1], at[2] + face[2]};
      if (!VoxelGrid::Contains(next[0], next[1], next[2])) continue;
      const std::size_t n = VoxelGrid::Index(next[0], next[1], next[2]);
      if (shell.occupied[n] != 0 || outside.occupied[n] != 0) continue;
      outside.occupied[n] = 1;
      stack.push_back(next);
    }
  }
  return outside;
}

// Within the shell voxels, marks the cells that the outside reaches.
void FloodShellVoxels(const VoxelGrid& shell, const VoxelGrid& outside, Cells& cells) {
  std::vector<std::array<int, 3>> stack;
  const auto enter = [&](int i, int j, int k) {
    std::uint8_t& cell = cells[FineIndex(i, j, k)];
    if (cell != kFree || shell.occupied[VoxelGrid::Index(i / kFine, j / kFine, k / kFine)] == 0)
      return;
    cell = kOutside;
    stack.push_back({i, j, k});
  };
  const auto is_outside = [&](int i, int j, int k) {
    return outside.occupied[VoxelGrid::Index(i / kFine, j / kFine, k / kFine)] != 0;
  };
  const auto enter_from_outside = [&](int i, int j, int k) {
    const bool seed =
        std::any_of(kFaces.begin(), kFaces.end(), [&](const std::array<int, 3>& face) {
          return is_outside(i + face[0], j + face[1], k + face[2]);
        });
    if (seed) enter(i, j, k);
  };
  // The rim of the cube holds no shell, so neighbours are within it.
  for (int n = 0; n < kGridSize * kGridSize * kGridSize; ++n) {
    if (shell.occupied[static_cast<std::size_t>(n)] == 0) continue;
    const int i = n / (kGridSize * kGridSize) * kFine;
    const int j = n / kGridSize % kGridSize * kFine;
    const int k = n % kGridSize * kFine;
    for (int a = 0; a < kFine; ++a) {
      for (int b = 0; b < kFine; ++b) {
        for (int c = 0; c < kFine; ++c) enter_from_outside(i + a, j + b, k + c);
      }
    }
  }
  while (!stack.empty()) {
    const std::array<int, 3> at = stack.back();
    stack.pop_back();
    for (const auto& face : kFaces) enter(at[0] + face[0], at[1] + face[1], at[2] + face[2]);
  }
}

float SolidShare(const Cells& cells, int i, int j, int k) {
  int solid = 0;
  for (int a = 0; a < kFine; ++a) {
    for (int b = 0; b < kFine; ++b) {
      for (int c = 0; c < kFine; ++c) {
        solid += cells[FineIndex(i * kFine + a, j * kFine + b, k * kFine + c)] != kOutside ? 1 : 0;
      }
    }
  }
  return static_cast<float>(solid) / (kFine * kFine * kFine);
}

VoxelGrid SolidWithin(Cells& cells) {
  const VoxelGrid shell = ShellVoxels(cells);
  const VoxelGrid outside = OutsideVoxels(shell);
  FloodShellVoxels(shell, outside, cells);
  std::vector<float> shares(shell.occupied.size());
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        const std::size_t n = VoxelGrid::Index(i, j, k);
        shares[n] = outside.occupied[n] != 0 ? 0.0F : 1.0F;
        if (shell.occupied[n] != 0) shares[n] = SolidShare(cells, i, j, k);
      }
    }
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
  constexpr double kSmallest = 1e-9;
  if (!(longest > kSmallest) || !std::isfinite(longest)) {
    return InvalidInput("mesh has no extent");
  }
  const double scale = kModelExtent * kFineSize / longest;
  Cells cells(static_cast<std::size_t>(kFineSize) * kFineSize * kFineSize, kFree);
  for (Triangle& triangle : triangles) {
    for (Eigen::Vector3d& corner : triangle) {
      corner = (scale * (corner - box.Center())).array() + 0.5 * kFineSize;
    }
    MarkTriangle(triangle, cells);
  }
  return SolidWithin(cells);
}

}  // namespace deepslam::shape
