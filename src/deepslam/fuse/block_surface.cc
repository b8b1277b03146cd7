#include "deepslam/fuse/block_surface.h"

#include <open3d/pipelines/integration/MarchingCubesConst.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "deepslam/core/parallel.h"
#include "deepslam/core/wide_vectors.h"

namespace deepslam::fuse {
namespace {

// Voxels; unsigned, for bits of a row.
constexpr auto kSide = static_cast<std::uint32_t>(VoxelBlock::kSide);

// A voxel of the block in work or of one beside it.
struct Corner {
  const VoxelBlock* block = nullptr;  // null where no block is open
  std::size_t block_number = 0;
  std::size_t voxel = 0;

  [[nodiscard]] bool measured() const { return block != nullptr && block->weight[voxel] > 0; }
  [[nodiscard]] double distance() const { return static_cast<double>(block->distance[voxel]); }
};

constexpr std::size_t kBlockRows = std::size_t{kSide} * kSide;

// Of the voxels of a block, row by row along z.
struct BlockBits {
  std::array<std::uint16_t, kBlockRows> measured{};
  std::array<std::uint16_t, kBlockRows> inside{};
};

DEEPSLAM_WIDE_VECTORS
BlockBits BitsOf(const VoxelBlock& block) {
  BlockBits bits;
  for (std::size_t row = 0; row < kBlockRows; ++row) {
    const std::uint16_t* weights = block.weight.data() + row * kSide;
    const float* distances = block.distance.data() + row * kSide;
    unsigned measured = 0;
    unsigned inside = 0;
    for (unsigned z = 0; z < kSide; ++z) {
      measured |= weights[z] > 0 ? 1U << z : 0U;
      inside |= distances[z] < 0 ? 1U << z : 0U;
    }
    bits.measured[row] = static_cast<std::uint16_t>(measured);
    bits.inside[row] = static_cast<std::uint16_t>(inside);
  }
  return bits;
}

// Of four rows beside each other, one voxel longer than a block's.
struct RowBits {
  std::uint32_t measured = ~0U;  // by all
  std::uint32_t some_inside = 0;
  std::uint32_t all_inside = ~0U;
};

class SurfaceBuilder {
 public:
  explicit SurfaceBuilder(const VoxelBlocks& blocks) : blocks_(blocks), bits_(blocks.size()) {
    ParallelFor(bits_.size(), [&](std::size_t n) { bits_[n] = BitsOf(blocks.at(n)); });
  }

  TriangleMesh Build() {
    for (number_ = 0; number_ < blocks_.size(); ++number_) {
      FindNeighbours();
      for (int x = 0; x < VoxelBlock::kSide; ++x) {
        for (int y = 0; y < VoxelBlock::kSide; ++y) {
          for (std::uint32_t cells = CrossedCells(x, y); cells != 0; cells &= cells - 1)
            AddCell({x, y, std::countr_zero(cells)});
        }
      }
    }
    return std::move(mesh_);
  }

 private:
  // Of the cells of a row along z, bit by bit: those that the surface passes through, all corners
  // measured.
  [[nodiscard]] std::uint32_t CrossedCells(int x, int y) const {
    RowBits bits;
    for (const int dx : {0, 1}) {
      for (const int dy : {0, 1}) AddRow(x + dx, y + dy, bits);
    }
    const std::uint32_t measured = bits.measured & bits.measured >> 1U;
    const std::uint32_t some_inside = bits.some_inside | bits.some_inside >> 1U;
    const std::uint32_t all_inside = bits.all_inside & bits.all_inside >> 1U;
    return measured & some_inside & ~all_inside & ((1U << kSide) - 1);
  }

  void AddRow(int x, int y, RowBits& bits) const {
    const auto column = static_cast<std::uint32_t>(x);
    const auto line = static_cast<std::uint32_t>(y);
    const std::uint32_t which = (column / kSide) << 2U | (line / kSide) << 1U;
    const std::size_t row = std::size_t{column % kSide} * kSide + line % kSide;
    std::uint32_t measured = 0;
    std::uint32_t inside = 0;
    if (const auto& number = neighbours_[which]) {
      measured = bits_[*number].measured[row];
      inside = bits_[*number].inside[row];
    }
    if (const auto& number = neighbours_[which | 1U]) {
      measured |= (bits_[*number].measured[row] & 1U) << kSide;
      inside |= (bits_[*number].inside[row] & 1U) << kSide;
    }
    bits.measured &= measured;
    bits.some_inside |= inside;
    bits.all_inside &= inside;
  }

  void FindNeighbours() {
    for (std::uint32_t n = 0; n < 8; ++n) {
      const Eigen::Vector3i offset(
          static_cast<int>(n >> 2U & 1U), static_cast<int>(n >> 1U & 1U), static_cast<int>(n & 1U));
      neighbours_[n] = n == 0 ? number_ : blocks_.Find(blocks_.at(number_).index + offset);
    }
  }

  // `place` lies in the block or one step beyond its end.
  [[nodiscard]] Corner CornerAt(const Eigen::Vector3i& place) const {
    std::uint32_t which = 0;
    std::size_t voxel = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto at = static_cast<std::uint32_t>(place[axis]);
      which = which << 1U | at / kSide;
      voxel = voxel * kSide + at % kSide;
    }
    const std::optional<std::size_t>& number = neighbours_[which];
    if (!number) return {};
    return {&blocks_.at(*number), *number, voxel};
  }

  void AddCell(const Eigen::Vector3i& place) {
    std::array<Corner, 8> corners;
    std::size_t inside = 0;
    for (std::size_t n = 0; n < 8; ++n) {
      corners[n] = CornerAt(place + shift[n]);
      if (!corners[n].measured()) return;
      if (corners[n].distance() < 0) inside |= std::size_t{1} << n;
    }
    if (inside == 0 || inside == 255) return;
    std::array<std::uint32_t, 12> vertices{};
    for (std::size_t edge = 0; edge < 12; ++edge) {
      if ((static_cast<std::uint32_t>(edge_table[inside]) >> edge & 1U) != 0)
        vertices[edge] = VertexOn(place, edge, corners);
    }
    const auto& faces = tri_table[inside];
    for (std::size_t n = 0; faces[n] != -1; n += 3) {
      mesh_.faces.push_back({vertices[static_cast<std::size_t>(faces[n])],
                             vertices[static_cast<std::size_t>(faces[n + 2])],
                             vertices[static_cast<std::size_t>(faces[n + 1])]});
    }
  }

  // An edge belongs to the voxel at its lower end, whichever of its cells comes first.
  std::uint32_t VertexOn(const Eigen::Vector3i& place,
                         std::size_t edge,
                         const std::array<Corner, 8>& corners) {
    const auto axis = static_cast<std::size_t>(edge_shift[edge][3]);
    const Corner& low = corners[static_cast<std::size_t>(edge_to_vert[edge][0])];
    const Corner& high = corners[static_cast<std::size_t>(edge_to_vert[edge][1])];
    const std::uint64_t key = (low.block_number * VoxelBlock::kVoxels + low.voxel) * 4 + axis;
    const auto [found, is_new] =
        vertex_of_.try_emplace(key, static_cast<std::uint32_t>(mesh_.vertices.size()));
    if (!is_new) return found->second;
    const double from_low = std::abs(low.distance());
    const double from_high = std::abs(high.distance());
    const double t = from_low / (from_low + from_high);
    const Eigen::Vector3i at = blocks_.at(number_).index * VoxelBlock::kSide + place +
                               Eigen::Vector3i(edge_shift[edge].head<3>());
    Eigen::Vector3d p = (at.cast<double>().array() + 0.5) * blocks_.voxel_m();
    p[static_cast<Eigen::Index>(axis)] += t * blocks_.voxel_m();
    mesh_.vertices.push_back(p.cast<float>());
    std::array<std::uint8_t, 3> colour{};
    for (std::size_t c = 0; c < 3; ++c) {
      const double mean =
          (1 - t) * low.block->colour[c][low.voxel] + t * high.block->colour[c][high.voxel];
      colour[c] = static_cast<std::uint8_t>(
          std::clamp(std::lround(mean / VoxelBlock::kColourSteps), 0L, 255L));
    }
    mesh_.colours.push_back({colour[0], colour[1], colour[2]});
    return found->second;
  }

  const VoxelBlocks& blocks_;
  std::vector<BlockBits> bits_;                           // of each block
  std::size_t number_ = 0;                                // of the block in work
  std::array<std::optional<std::size_t>, 8> neighbours_;  // x, y, z one further by bits 2, 1, 0
  std::unordered_map<std::uint64_t, std::uint32_t> vertex_of_;
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh SurfaceOf(const VoxelBlocks& blocks) { return SurfaceBuilder(blocks).Build(); }

}  // namespace deepslam::fuse
