#include "deepslam/fuse/voxel_blocks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_set>

#include "deepslam/core/parallel.h"

namespace deepslam::fuse {
namespace {

constexpr int kDepthStride = 4;  // px between the pixels that open blocks; Open3D's own default
constexpr int kSide = VoxelBlock::kSide;

// Distance along the ray by distance along the optical axis.
Image<float> RayLengths(const PinholeCamera& camera) {
  Image<float> lengths(camera.width, camera.height);
  const float inverse_fx = 1.0F / static_cast<float>(camera.fx);
  const float inverse_fy = 1.0F / static_cast<float>(camera.fy);
  for (int v = 0; v < camera.height; ++v) {
    const float y = (static_cast<float>(v) - static_cast<float>(camera.cy)) * inverse_fy;
    for (int u = 0; u < camera.width; ++u) {
      const float x = (static_cast<float>(u) - static_cast<float>(camera.cx)) * inverse_fx;
      lengths(u, v) = std::sqrt(x * x + y * y + 1.0F);
    }
  }
  return lengths;
}

}  // namespace

struct VoxelBlocks::View {
  const DepthImage& depth_m;
  const ColourImage& colour;
  const PinholeCamera& camera;
  const Image<float>& ray_lengths;
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
  return (p_world / (voxel_m_ * kSide)).array().floor().cast<int>();
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

void VoxelBlocks::Add(const View& view, VoxelBlock& block) const {
  const auto voxel = static_cast<float>(voxel_m_);
  const float half = 0.5F * voxel;
  constexpr auto kSteps = static_cast<float>(VoxelBlock::kColourSteps);
  const auto truncation = static_cast<float>(truncation_m_);
  const float inverse_truncation = 1.0F / truncation;
  const auto fx = static_cast<float>(view.camera.fx);
  const auto fy = static_cast<float>(view.camera.fy);
  const auto cx = static_cast<float>(view.camera.cx);
  const auto cy = static_cast<float>(view.camera.cy);
  const float safe_width = static_cast<float>(view.camera.width) - 0.0001F;
  const float safe_height = static_cast<float>(view.camera.height) - 0.0001F;
  const Eigen::Vector3f origin = (block.index.cast<double>() * (voxel_m_ * kSide)).cast<float>();
  const Eigen::Vector3f step_z = view.camera_from_world.topRows<3>().col(2) * voxel;
  std::size_t n = 0;
  for (int x = 0; x < kSide; ++x) {
    for (int y = 0; y < kSide; ++y) {
      const Eigen::Vector4f p_world(half + voxel * static_cast<float>(x) + origin.x(),
                                    half + voxel * static_cast<float>(y) + origin.y(),
                                    half + origin.z(),
                                    1.0F);
      Eigen::Vector3f p_camera = view.camera_from_world.topRows<3>() * p_world;
      for (int z = 0; z < kSide; ++z, ++n, p_camera += step_z) {
        if (!(p_camera.z() > 0)) continue;
        const float u_place = p_camera.x() * fx / p_camera.z() + cx + 0.5F;
        const float v_place = p_camera.y() * fy / p_camera.z() + cy + 0.5F;
        const bool inside = u_place >= 0.0001F && u_place < safe_width && v_place >= 0.0001F &&
                            v_place < safe_height;
        if (!inside) continue;
        const int u = static_cast<int>(u_place);
        const int v = static_cast<int>(v_place);
        const float depth = view.depth_m(u, v);
        if (!(depth > 0)) continue;
        const float ahead = (depth - p_camera.z()) * view.ray_lengths(u, v);
        if (!(ahead > -truncation)) continue;
        std::uint16_t& weight = block.weight[n];
        const auto before = static_cast<float>(weight);
        const float share = 1.0F / (before + 1.0F);
        float& distance = block.distance[n];
        distance = (distance * before + std::min(1.0F, ahead * inverse_truncation)) * share;
        const Rgb8 seen = view.colour(u, v);
        const std::array<std::uint8_t, 3> channels = {seen.r, seen.g, seen.b};
        for (std::size_t c = 0; c < 3; ++c) {
          std::uint16_t& mean = block.colour[n][c];
          mean = static_cast<std::uint16_t>(
              (static_cast<float>(mean) * before + kSteps * static_cast<float>(channels[c])) *
                  share +
              0.5F);
        }
        if (weight < std::numeric_limits<std::uint16_t>::max()) ++weight;
      }
    }
  }
}

bool VoxelBlocks::Integrate(const DepthImage& depth_m,
                            const ColourImage& colour,
                            const PinholeCamera& camera,
                            const Pose3& world_from_camera,
                            std::size_t max_blocks) {
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
  const Image<float> ray_lengths = RayLengths(camera);
  const View view{
      depth_m, colour, camera, ray_lengths, world_from_camera.Inverse().Matrix().cast<float>()};
  constexpr std::size_t kChunk = 8;
  ParallelForChunks(touched.size(), kChunk, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) Add(view, *touched[n]);
  });
  return true;
}

}  // namespace deepslam::fuse
