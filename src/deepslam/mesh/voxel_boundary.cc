#include "deepslam/mesh/voxel_boundary.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "deepslam/shape/outside_voxels.h"

namespace deepslam::mesh {
namespace {

// One free voxel all round, so that no neighbour lookup leaves the array and a full grid is closed
// off.
constexpr int kPaddedSide = kGridSize + 2;
constexpr std::size_t kNumPaddedVoxels =
    static_cast<std::size_t>(kPaddedSide) * kPaddedSide * kPaddedSide;
constexpr std::array<std::ptrdiff_t, 3> kStep = {
    static_cast<std::ptrdiff_t>(kPaddedSide) * kPaddedSide, kPaddedSide, 1};

using Solid = std::vector<std::uint8_t>;

std::ptrdiff_t Offset(int i, int j, int k) { return i * kStep[0] + j * kStep[1] + k * kStep[2]; }

std::uint8_t& At(Solid& solid, std::ptrdiff_t offset) {
  return solid[static_cast<std::size_t>(offset)];
}
std::uint8_t At(const Solid& solid, std::ptrdiff_t offset) {
  return solid[static_cast<std::size_t>(offset)];
}

Solid Padded(const VoxelGrid& grid) {
  Solid solid(kNumPaddedVoxels, 0);
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        At(solid, Offset(i + 1, j + 1, k + 1)) = grid.At(i, j, k) ? 1 : 0;
      }
    }
  }
  return solid;
}

bool Inside(std::ptrdiff_t offset) {
  return offset >= 0 && offset < static_cast<std::ptrdiff_t>(kNumPaddedVoxels);
}

// Marks the 6-connected piece of equal occupancy around `seed` with `label`; returns its size. The
// array's wrap-around at its faces joins padding with padding only, which is one piece anyway.
std::size_t Flood(const Solid& solid, std::ptrdiff_t seed, int label, std::vector<int>& labels) {
  std::vector<std::ptrdiff_t> queue = {seed};
  labels[static_cast<std::size_t>(seed)] = label;
  for (std::size_t head = 0; head < queue.size(); ++head) {
    for (const std::ptrdiff_t step : kStep) {
      for (const std::ptrdiff_t next : {queue[head] - step, queue[head] + step}) {
        if (!Inside(next) || labels[static_cast<std::size_t>(next)] != 0 ||
            At(solid, next) != At(solid, seed)) {
          continue;
        }
        labels[static_cast<std::size_t>(next)] = label;
        queue.push_back(next);
      }
    }
  }
  return queue.size();
}

// Of the unpadded grid's row, its first voxel.
std::ptrdiff_t FirstOf(std::size_t row) {
  return Offset(static_cast<int>(row / kGridSize) + 1, static_cast<int>(row % kGridSize) + 1, 1);
}

// Makes solid what the outside does not reach. Returns whether anything changed.
bool FillCavities(Solid& solid) {
  shape::VoxelRows empty(shape::kNumVoxelRows, 0);
  for (std::size_t row = 0; row < empty.size(); ++row) {
    const std::uint8_t* const voxels = &At(solid, FirstOf(row));
    for (int k = 0; k < kGridSize; ++k)
      empty[row] |= static_cast<std::uint64_t>(voxels[k] == 0 ? 1 : 0) << k;
  }
  const shape::VoxelRows outside = shape::OutsideVoxels(empty);
  bool changed = false;
  for (std::size_t row = 0; row < empty.size(); ++row) {
    const std::uint64_t rest = empty[row] & ~outside[row];
    if (rest == 0) continue;
    changed = true;
    std::uint8_t* const voxels = &At(solid, FirstOf(row));
    for (int k = 0; k < kGridSize; ++k) voxels[k] |= static_cast<std::uint8_t>((rest >> k) & 1U);
  }
  return changed;
}

void DropSmallParts(Solid& solid, double min_share) {
  std::vector<int> labels(kNumPaddedVoxels, 0);
  std::vector<std::size_t> sizes = {0};
  for (std::size_t n = 0; n < kNumPaddedVoxels; ++n) {
    if (solid[n] == 0 || labels[n] != 0) continue;
    sizes.push_back(
        Flood(solid, static_cast<std::ptrdiff_t>(n), static_cast<int>(sizes.size()), labels));
  }
  std::size_t total = 0;
  for (const std::size_t size : sizes) total += size;
  const std::size_t largest = *std::max_element(sizes.begin(), sizes.end());
  const double bound =
      std::min(static_cast<double>(largest), min_share * static_cast<double>(total));
  for (std::size_t n = 0; n < kNumPaddedVoxels; ++n) {
    if (solid[n] != 0 && static_cast<double>(sizes[static_cast<std::size_t>(labels[n])]) < bound) {
      solid[n] = 0;
    }
  }
}

int NumSolidNeighbours(const Solid& solid, std::ptrdiff_t offset) {
  int count = 0;
  for (const std::ptrdiff_t step : kStep)
    count += At(solid, offset - step) + At(solid, offset + step);
  return count;
}

// Of two empty voxels the one that is more embedded, so that the solid changes its shape least.
void FillOneOf(Solid& solid, std::ptrdiff_t a, std::ptrdiff_t b) {
  At(solid, NumSolidNeighbours(solid, b) > NumSolidNeighbours(solid, a) ? b : a) = 1;
}

// Two solid voxels of a 2 x 2 square that share an edge alone.
bool FixSquare(Solid& solid, std::ptrdiff_t at, std::ptrdiff_t u, std::ptrdiff_t v) {
  const bool a = At(solid, at) != 0;
  const bool b = At(solid, at + u) != 0;
  const bool c = At(solid, at + v) != 0;
  const bool d = At(solid, at + u + v) != 0;
  if (a != d || b != c || a == b) return false;
  if (a) {
    FillOneOf(solid, at + u, at + v);
  } else {
    FillOneOf(solid, at, at + u + v);
  }
  return true;
}

// Two voxels of a 2 x 2 x 2 cube that share a corner alone: both solid among empty ones, or both
// empty among solid ones.
bool FixCube(Solid& solid, std::ptrdiff_t at) {
  std::array<std::ptrdiff_t, 8> corner{};
  int count = 0;
  for (int n = 0; n < 8; ++n) {
    corner[static_cast<std::size_t>(n)] = at + Offset((n >> 2) & 1, (n >> 1) & 1, n & 1);
    count += At(solid, corner[static_cast<std::size_t>(n)]);
  }
  if (count != 2 && count != 6) return false;
  const std::uint8_t odd = count == 2 ? 1 : 0;
  for (std::size_t n = 0; n < 4; ++n) {
    if (At(solid, corner[n]) != odd || At(solid, corner[7 - n]) != odd) continue;
    if (odd == 0) {
      FillOneOf(solid, corner[n], corner[7 - n]);
    } else {
      At(solid, corner[n ^ 1U]) = 1;  // leaves an edge contact, which FixSquare then mends
    }
    return true;
  }
  return false;
}

// Filling only ever adds voxels inside the bounding box, so this ends.
void MakeWellComposed(Solid& solid) {
  bool changed = true;
  while (changed) {
    changed = false;
    for (int i = 0; i + 1 < kPaddedSide; ++i) {
      for (int j = 0; j + 1 < kPaddedSide; ++j) {
        for (int k = 0; k + 1 < kPaddedSide; ++k) {
          const std::ptrdiff_t at = Offset(i, j, k);
          changed |= FixSquare(solid, at, kStep[0], kStep[1]);
          changed |= FixSquare(solid, at, kStep[0], kStep[2]);
          changed |= FixSquare(solid, at, kStep[1], kStep[2]);
          changed |= FixCube(solid, at);
        }
      }
    }
    if (!changed) changed = FillCavities(solid);
  }
}

// Number of voxels equal to the one at `offset`, from it along `step`; at most limit + 1.
int RunLength(const Solid& solid, std::ptrdiff_t offset, std::ptrdiff_t step, int limit) {
  int run = 1;
  while (run <= limit && Inside(offset + run * step) &&
         At(solid, offset + run * step) == At(solid, offset)) {
    ++run;
  }
  return run;
}

class BoundaryBuilder {
 public:
  explicit BoundaryBuilder(const Solid& solid) : solid_(solid), ids_(kNumPaddedVoxels, kNone) {}

  VoxelBoundary Build() && {
    for (int i = 1; i + 1 < kPaddedSide; ++i) {
      for (int j = 1; j + 1 < kPaddedSide; ++j) {
        for (int k = 1; k + 1 < kPaddedSide; ++k) {
          if (At(solid_, Offset(i, j, k)) == 0) continue;
          for (int axis = 0; axis < 3; ++axis) {
            AddFace({i, j, k}, axis, false);
            AddFace({i, j, k}, axis, true);
          }
        }
      }
    }
    AddThinPairs();
    AddSteps();
    return std::move(boundary_);
  }

 private:
  using Voxel = std::array<int, 3>;
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;  // the corner has no vertex yet

  // Corner (i, j, k) is the lowest corner of voxel (i, j, k).
  std::uint32_t VertexAt(const Voxel& corner) {
    std::uint32_t& id = ids_[static_cast<std::size_t>(Offset(corner[0], corner[1], corner[2]))];
    if (id == kNone) {
      id = static_cast<std::uint32_t>(boundary_.vertices.size());
      boundary_.vertices.emplace_back(corner[0] - 1, corner[1] - 1, corner[2] - 1);
    }
    return id;
  }

  void AddFace(const Voxel& voxel, int axis, bool upper) {
    const std::size_t a = static_cast<std::size_t>(axis);
    const std::ptrdiff_t offset = Offset(voxel[0], voxel[1], voxel[2]);
    const std::ptrdiff_t step = upper ? kStep[a] : -kStep[a];
    if (At(solid_, offset + step) != 0) return;
    const std::size_t u = (a + 1) % 3;
    const std::size_t v = (a + 2) % 3;
    std::array<std::uint32_t, 4> quad{};
    for (std::size_t n = 0; n < 4; ++n) {
      Voxel corner = voxel;
      corner[a] += upper ? 1 : 0;
      corner[u] += (n == 1 || n == 2) ? 1 : 0;
      corner[v] += n >= 2 ? 1 : 0;
      quad[upper ? n : 3 - n] = VertexAt(corner);
    }
    boundary_.quads.push_back(quad);
  }

  void AddThinPairs() {
    const std::size_t num_vertices = boundary_.vertices.size();
    for (std::uint32_t id = 0; id < num_vertices; ++id) {
      const Eigen::Vector3i corner = boundary_.vertices[id].cast<int>() + Eigen::Vector3i::Ones();
      for (int axis = 0; axis < 3; ++axis) AddThinPairsAbove(id, corner, axis);
    }
  }

  // The surface passes `corner` between two voxels along `axis`; how far above does it pass again?
  void AddThinPairsAbove(std::uint32_t id, const Eigen::Vector3i& corner, int axis) {
    const std::ptrdiff_t step = kStep[static_cast<std::size_t>(axis)];
    const std::ptrdiff_t u = kStep[static_cast<std::size_t>((axis + 1) % 3)];
    const std::ptrdiff_t v = kStep[static_cast<std::size_t>((axis + 2) % 3)];
    const std::ptrdiff_t at = Offset(corner.x(), corner.y(), corner.z());
    int nearest = kThinVoxels + 1;
    for (const std::ptrdiff_t above : {at, at - u, at - v, at - u - v}) {
      if (At(solid_, above) == At(solid_, above - step)) continue;
      nearest = std::min(nearest, RunLength(solid_, above, step, kThinVoxels));
    }
    if (nearest > kThinVoxels || !Inside(at + nearest * step)) return;
    const std::uint32_t other = ids_[static_cast<std::size_t>(at + nearest * step)];
    if (other != kNone) boundary_.thin_pairs.push_back({id, other, axis, nearest});
  }

  void AddSteps() {
    for (const Eigen::Vector3d& vertex : boundary_.vertices) {
      const Eigen::Vector3i corner = vertex.cast<int>() + Eigen::Vector3i::Ones();
      const std::ptrdiff_t above = Offset(corner.x(), corner.y(), corner.z());
      std::array<std::uint8_t, 3> at_step = {0, 0, 0};
      for (std::size_t along = 0; along < 3; ++along) {
        if (!IsConcaveEdge(above, along) && !IsConcaveEdge(above - kStep[along], along)) continue;
        at_step[(along + 1) % 3] = 1;
        at_step[(along + 2) % 3] = 1;
      }
      boundary_.at_step.push_back(at_step);
    }
  }

  // Of the four voxels round the lowest edge along an axis of voxel `at` all but one are solid.
  [[nodiscard]] bool IsConcaveEdge(std::ptrdiff_t at, std::size_t along) const {
    const std::ptrdiff_t u = kStep[(along + 1) % 3];
    const std::ptrdiff_t v = kStep[(along + 2) % 3];
    return At(solid_, at) + At(solid_, at - u) + At(solid_, at - v) + At(solid_, at - u - v) == 3;
  }

  const Solid& solid_;
  std::vector<std::uint32_t> ids_;
  VoxelBoundary boundary_;
};

}  // namespace

Result<VoxelBoundary> ExtractVoxelBoundary(const VoxelGrid& grid, double min_component_share) {
  const std::size_t expected = static_cast<std::size_t>(kGridSize) * kGridSize * kGridSize;
  if (grid.occupied.size() != expected) {
    return InvalidInput("voxel grid holds " + std::to_string(grid.occupied.size()) +
                        " voxels instead of " + std::to_string(expected));
  }
  if (std::none_of(grid.occupied.begin(), grid.occupied.end(), [](auto v) { return v != 0; })) {
    return InvalidInput("voxel grid is empty: there is no surface to extract");
  }
  Solid solid = Padded(grid);
  FillCavities(solid);
  MakeWellComposed(solid);
  DropSmallParts(solid, min_component_share);
  return BoundaryBuilder(solid).Build();
}

}  // namespace deepslam::mesh
