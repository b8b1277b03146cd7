#include "deepslam/fuse/voxel_blocks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_set>

#include "deepslam/core/parallel.h"
#include "deepslam/core/wide_vectors.h"
#include "deepslam/fuse/voxel_row.h"

namespace deepslam::fuse {
namespace {

constexpr int kDepthStride = 4;  // px between the pixels that open blocks; Open3D's own default
constexpr int kSide = VoxelBlock::kSide;

// False where no voxel of the row is seen: nothing was measured, or it lies too far behind. Across
// a surface that is as far as the truncation reaches along the ray, and a voxel at least: less
// would lose what rays graze, more would make boards thicker.
inline bool Measure(const DepthImage& depth_m,
                    const Image<float>* cosines,
                    const PinholeCamera& camera,
                    float truncation_m,
                    float voxel_m,
                    const Row& depth_voxel_m,
                    RowPlaces& places) {
  Row measured_m;
  bool any = false;
  for (std::size_t n = 0; n < kSide; ++n) {
    const std::int32_t pixel = places.pixel[n];
    const float depth = depth_m.data()[std::max(pixel, 0)];
    measured_m[n] = pixel < 0 ? 0.0F : depth;
    any |= pixel >= 0;
  }
  if (!any) return false;
  Row cosine;
  for (std::size_t n = 0; n < kSide; ++n)
    cosine[n] = cosines != nullptr ? cosines->data()[std::max(places.pixel[n], 0)] : 1.0F;
  const float inverse_fx = 1.0F / static_cast<float>(camera.fx);
  const float inverse_fy = 1.0F / static_cast<float>(camera.fy);
  const auto cx = static_cast<float>(camera.cx);
  const auto cy = static_cast<float>(camera.cy);
  std::int32_t num_seen = 0;
  for (std::size_t n = 0; n < kSide; ++n) {
    // Distance along the pixel's ray by distance along the optical axis.
    const float x = (static_cast<float>(places.u[n]) - cx) * inverse_fx;
    const float y = (static_cast<float>(places.v[n]) - cy) * inverse_fy;
    const float length = std::sqrt(x * x + y * y + 1.0F);
    const float ahead = (measured_m[n] - depth_voxel_m[n]) * length * cosine[n];
    const float reach_m = std::max(truncation_m * cosine[n], std::min(voxel_m, truncation_m));
    const bool seen = (measured_m[n] > 0) & (ahead > -reach_m);
    places.ahead_m[n] = ahead;
    places.pixel[n] = seen ? places.pixel[n] : -1;
    num_seen += seen ? 1 : 0;
  }
  return num_seen > 0;
}

// The means of the row's voxels, from `first` on, with what is seen of them.
inline void AddToMeans(const ColourImage& colour,
                       float inverse_truncation,
                       const RowPlaces& places,
                       std::size_t first,
                       VoxelBlock& block) {
  constexpr auto kSteps = static_cast<float>(VoxelBlock::kColourSteps);
  // The type's greatest; from then on the mean forgets the oldest.
  constexpr std::int32_t kMaxWeight = std::numeric_limits<std::uint16_t>::max();
  std::array<Row, 3> seen_colour;
  for (std::size_t n = 0; n < kSide; ++n) {
    // That of any pixel where none is seen: it counts nothing.
    const Rgb8& seen = colour.data()[std::max(places.pixel[n], 0)];
    seen_colour[0][n] = static_cast<float>(seen.r);
    seen_colour[1][n] = static_cast<float>(seen.g);
    seen_colour[2][n] = static_cast<float>(seen.b);
  }
  Row before;
  Row share;
  Row is_seen;  // 1 or 0: without branches the loops are ones of whole vectors
  std::uint16_t* const weight = block.weight.data() + first;
  float* const distance = block.distance.data() + first;
  for (std::size_t n = 0; n < kSide; ++n) {
    const std::int32_t one = places.pixel[n] < 0 ? 0 : 1;
    const std::int32_t was = weight[n];
    is_seen[n] = static_cast<float>(one);
    before[n] = static_cast<float>(was);
    share[n] = 1.0F / (before[n] + 1.0F);
    weight[n] = static_cast<std::uint16_t>(std::min(was + one, kMaxWeight));
  }
  for (std::size_t n = 0; n < kSide; ++n) {
    const float ahead = std::min(1.0F, places.ahead_m[n] * inverse_truncation);
    const float mean = (distance[n] * before[n] + ahead) * share[n];
    distance[n] += is_seen[n] * (mean - distance[n]);
  }
  for (std::size_t c = 0; c < 3; ++c) {
    std::uint16_t* const means = block.colour[c].data() + first;
    for (std::size_t n = 0; n < kSide; ++n) {
      const auto was = static_cast<float>(static_cast<std::int32_t>(means[n]));
      const float mean = (was * before[n] + kSteps * seen_colour[c][n]) * share[n] + 0.5F;
      means[n] =
          static_cast<std::uint16_t>(static_cast<std::int32_t>(was + is_seen[n] * (mean - was)));
    }
  }
}

}  // namespace

struct VoxelBlocks::View {
  const DepthImage& depth_m;
  const Image<float>* cosines;  // none: distances along the rays
  const ColourImage& colour;
  const PinholeCamera& camera;
  Eigen::Matrix4f camera_from_world;
};

std::size_t VoxelBlocks::Hash::operator()(const Eigen::Vector3i& index) const {
  std::uint64_t hash = 0;
  for (int axis = 0; axis < 3; ++axis) {
    hash = (hash ^ static_cast<std::uint32_t>(index[axis])) * 0x9E3779B97F4A7C15ULL;
    hash ^= hash >> 29U;
  }
  return hash;
}

VoxelBlocks::VoxelBlocks(double voxel_m, double truncation_m)
    : voxel_m_(voxel_m), truncation_m_(truncation_m) {}

std::optional<std::size_t> VoxelBlocks::Find(const Eigen::Vector3i& index) const {
  const auto found = numbers_.find(index);
  return found == numbers_.end() ? std::nullopt : std::optional(found->second);
}

Eigen::Vector3i VoxelBlocks::BlockOf(const Eigen::Vector3d& p_world) const {
  // Floor, which is a call of a library on processors without SSE4.1.
  const Eigen::Array3d at = p_world / (voxel_m_ * kSide);
  const Eigen::Array3i towards_zero = at.cast<int>();
  return towards_zero - (towards_zero.cast<double>() > at).cast<int>();
}

// Indices of the blocks, each once, in the order of the pixels.
std::vector<Eigen::Vector3i> VoxelBlocks::Reached(const DepthImage& depth_m,
                                                  const PinholeCamera& camera,
                                                  const Pose3& world_from_camera) const {
  std::vector<Eigen::Vector3i> reached;
  std::unordered_set<Eigen::Vector3i, Hash> known;
  Eigen::Vector3i last_low = Eigen::Vector3i::Constant(std::numeric_limits<int>::min());
  Eigen::Vector3i last_high = last_low;
  for (int v = 0; v < depth_m.height(); v += kDepthStride) {
    for (int u = 0; u < depth_m.width(); u += kDepthStride) {
      const float depth = depth_m(u, v);
      if (!(depth > 0)) continue;
      const Eigen::Vector3d p_world =
          world_from_camera * camera.Unproject(u, v, static_cast<double>(depth));
      const Eigen::Vector3i low = BlockOf(p_world.array() - truncation_m_);
      const Eigen::Vector3i high = BlockOf(p_world.array() + truncation_m_);
      if (low == last_low && high == last_high) continue;
      last_low = low;
      last_high = high;
      for (int x = low.x(); x <= high.x(); ++x) {
        for (int y = low.y(); y <= high.y(); ++y) {
          for (int z = low.z(); z <= high.z(); ++z) {
            if (known.emplace(x, y, z).second) reached.emplace_back(x, y, z);
          }
        }
      }
    }
  }
  return reached;
}

DEEPSLAM_WIDE_VECTORS void VoxelBlocks::Add(const View& view, VoxelBlock& block) const {
  const auto voxel = static_cast<float>(voxel_m_);
  const float half = 0.5F * voxel;
  const auto truncation = static_cast<float>(truncation_m_);
  const Eigen::Vector3f origin = (block.index.cast<double>() * (voxel_m_ * kSide)).cast<float>();
  const Eigen::Vector3f step_z = view.camera_from_world.topRows<3>().col(2) * voxel;
  RowPlaces places;
  Row depth_voxel_m;
  std::size_t first = 0;
  for (int x = 0; x < kSide; ++x) {
    for (int y = 0; y < kSide; ++y, first += kSide) {
      const Eigen::Vector4f p_world(half + voxel * static_cast<float>(x) + origin.x(),
                                    half + voxel * static_cast<float>(y) + origin.y(),
                                    half + origin.z(),
                                    1.0F);
      const Eigen::Vector3f p_camera = view.camera_from_world.topRows<3>() * p_world;
      PlacePixels(view.camera, p_camera, step_z, places, depth_voxel_m);
      if (Measure(
              view.depth_m, view.cosines, view.camera, truncation, voxel, depth_voxel_m, places))
        AddToMeans(view.colour, 1.0F / truncation, places, first, block);
    }
  }
}

bool VoxelBlocks::Integrate(const DepthImage& depth_m,
                            const ColourImage& colour,
                            const PinholeCamera& camera,
                            const Pose3& world_from_camera,
                            std::size_t max_blocks,
                            const Image<float>* cosines) {
  const std::vector<Eigen::Vector3i> reached = Reached(depth_m, camera, world_from_camera);
  const auto num_new = static_cast<std::size_t>(
      std::count_if(reached.begin(), reached.end(), [&](const Eigen::Vector3i& index) {
        return !numbers_.contains(index);
      }));
  if (blocks_.size() + num_new > max_blocks) return false;
  std::vector<VoxelBlock*> touched;
  for (const Eigen::Vector3i& index : reached) {
    const auto [found, is_new] = numbers_.try_emplace(index, blocks_.size());
    if (is_new) {
      blocks_.push_back(std::make_unique<VoxelBlock>());
      blocks_.back()->index = index;
    }
    touched.push_back(blocks_[found->second].get());
  }
  const View view{
      depth_m, cosines, colour, camera, world_from_camera.Inverse().Matrix().cast<float>()};
  // Blocks a thread takes at a time; the result does not depend on it.
  constexpr std::size_t kBlocksPerChunk = 8;
  ParallelForChunks(touched.size(), kBlocksPerChunk, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) Add(view, *touched[n]);
  });
  return true;
}

}  // namespace deepslam::fuse
