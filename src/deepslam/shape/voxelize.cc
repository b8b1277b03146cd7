#include "deepslam/shape/voxelize.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
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
  const auto cell = [&](double x) {
    return std::clamp(static_cast<int>(std::floor(x)), kLow, kHigh);
  };
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
    for (int b = 0; b <= row; ++b) {
      MarkPoint(begin + (static_cast<double>(b) / row) * along, cells);
    }
  }
}

void FloodOutside(Cells& cells) {
  std::vector<std::size_t> stack = {0};
  cells[0] = kOutside;
  constexpr std::array<std::size_t, 3> kStride = {
      static_cast<std::size_t>(kFineSize) * kFineSize, kFineSize, 1};
  while (!stack.empty()) {
    const std::size_t n = stack.back();
    stack.pop_back();
    for (const std::size_t stride : kStride) {
      const std::size_t coordinate = n / stride % kFineSize;
      if (coordinate > 0 && cells[n - stride] == kFree) {
        cells[n - stride] = kOutside;
        stack.push_back(n - stride);
      }
      if (coordinate + 1 < kFineSize && cells[n + stride] == kFree) {
        cells[n + stride] = kOutside;
        stack.push_back(n + stride);
      }
    }
  }
}

std::size_t CountSolid(const Cells& cells) {
  return cells.size() - static_cast<std::size_t>(std::count(cells.begin(), cells.end(), kOutside));
}

// Dilation of the cells equal to `value` by `radius` in the chessboard metric, axis by axis.
Cells Dilated(const Cells& cells, std::uint8_t value, int radius) {
  Cells result(cells.size());
  for (std::size_t n = 0; n < cells.size(); ++n) result[n] = cells[n] == value ? 1 : 0;
  constexpr std::array<std::size_t, 3> kStride = {
      static_cast<std::size_t>(kFineSize) * kFineSize, kFineSize, 1};
  std::array<std::uint8_t, kFineSize> line{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t a = 0; a < kFineSize; ++a) {
      for (std::size_t b = 0; b < kFineSize; ++b) {
        std::uint8_t* const first =
            result.data() + a * kStride[(axis + 1) % 3] + b * kStride[(axis + 2) % 3];
        line.fill(0);
        for (int n = 0; n < kFineSize; ++n) {
          if (first[static_cast<std::size_t>(n) * kStride[axis]] == 0) continue;
          const int begin = std::max(0, n - radius);
          const int end = std::min(kFineSize - 1, n + radius);
          std::fill(line.begin() + begin, line.begin() + end + 1, std::uint8_t{1});
        }
        for (std::size_t n = 0; n < kFineSize; ++n) first[n * kStride[axis]] = line[n];
      }
    }
  }
  return result;
}

// The outside where gaps of up to 2 * radius cells are shut: flood around the thickened shell, then
// let the outside grow back by the same radius, but not through the true shell.
Cells FloodedWithGapsShut(const Cells& shell, int radius) {
  Cells thick = Dilated(shell, kShell, radius);
  FloodOutside(thick);
  const Cells outside = Dilated(thick, kOutside, radius);
  Cells cells = shell;
  for (std::size_t n = 0; n < cells.size(); ++n) {
    if (cells[n] != kShell && outside[n] != 0) cells[n] = kOutside;
  }
  return cells;
}

VoxelGrid Reduced(const Cells& cells) {
  constexpr float kCell = 1.0F / (kFine * kFine * kFine);
  std::vector<float> shares(static_cast<std::size_t>(kGridSize) * kGridSize * kGridSize, 0.0F);
  for (int i = 0; i < kFineSize; ++i) {
    for (int j = 0; j < kFineSize; ++j) {
      for (int k = 0; k < kFineSize; ++k) {
        if (cells[FineIndex(i, j, k)] == kOutside) continue;
        shares[VoxelGrid::Index(i / kFine, j / kFine, k / kFine)] += kCell;
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
  Cells shell(static_cast<std::size_t>(kFineSize) * kFineSize * kFineSize, kFree);
  for (Triangle& triangle : triangles) {
    for (Eigen::Vector3d& corner : triangle) {
      corner = (scale * (corner - box.Center())).array() + 0.5 * kFineSize;
    }
    MarkTriangle(triangle, shell);
  }
  Cells cells = shell;
  FloodOutside(cells);
  // A closed hull of that surface would hold far more than the surface itself: the flood leaked in
  // through gaps.
  constexpr double kLeakRatio = 1.5;
  constexpr int kGapRadius = kFine / 2;
  Cells shut = FloodedWithGapsShut(shell, kGapRadius);
  if (static_cast<double>(CountSolid(shut)) > kLeakRatio * static_cast<double>(CountSolid(cells))) {
    cells = std::move(shut);
  }
  return Reduced(cells);
}

}  // namespace deepslam::shape
