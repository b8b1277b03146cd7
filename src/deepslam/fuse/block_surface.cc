#include "deepslam/fuse/block_surface.h"

#include <open3d/pipelines/integration/MarchingCubesConst.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>

namespace deepslam::fuse {
namespace {

constexpr auto kSide = static_cast<std::uint32_t>(VoxelBlock::kSide);

// A voxel of the block in work or of one beside it.
struct Corner {
  const VoxelBlock* block = nullptr;  // null where no block is open
  std::size_t block_number = 0;
  std::size_t voxel = 0;

  [[nodiscard]] bool measured() const { return block != nullptr && block->weight[voxel] > 0; }
  [[nodiscard]] double distance() const { return static_cast<double>(block->distance[voxel]); }
};

class SurfaceBuilder {
 public:
  explicit SurfaceBuilder(const VoxelBlocks& blocks) : blocks_(blocks) {}

  TriangleMesh Build() {
    for (number_ = 0; number_ < blocks_.size(); ++number_) {
      FindNeighbours();
      for (int x = 0; x < VoxelBlock::kSide; ++x) {
        for (int y = 0; y < VoxelBlock::kSide; ++y) {
          for (int z = 0; z < VoxelBlock::kSide; ++z) AddCell({x, y, z});
        }
      }
    }
    return std::move(mesh_);
  }

 private:
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
  std::size_t number_ = 0;                                // of the block in work
  std::array<std::optional<std::size_t>, 8> neighbours_;  // x, y, z one further by bits 2, 1, 0
  std::unordered_map<std::uint64_t, std::uint32_t> vertex_of_;
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh SurfaceOf(const VoxelBlocks& blocks) { return SurfaceBuilder(blocks).Build(); }

}  // namespace deepslam::fuse
