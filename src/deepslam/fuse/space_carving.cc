#include "deepslam/fuse/space_carving.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_set>
#include <utility>

#include "deepslam/core/parallel.h"
#include "deepslam/core/wide_vectors.h"
#include "deepslam/fuse/voxel_row.h"
#include "deepslam/geometry/depth_noise.h"

namespace deepslam::fuse {
namespace {

// px between the pixels whose rays open blocks: at 6 m, and 300 px of focal length, rays lie half a
// block of 0.64 m apart.
constexpr int kRayStride = 16;
static_assert(kRowVoxels == SpaceBlock::kSide);

// What a row's voxels are in the image: free where they lie before what was measured by more than a
// voxel and twice the noise, blind where nothing was measured.
struct RowCounts {
  std::array<std::uint8_t, kRowVoxels> is_free;
  std::array<std::uint8_t, kRowVoxels> is_blind;
};

inline void CountRow(const DepthImage& depth_m,
                     const DepthNoise& noise,
                     const SpaceOptions& options,
                     const RowPlaces& places,
                     const Row& depth_voxel_m,
                     RowCounts& counts) {
  Row measured_m;
  for (std::size_t n = 0; n < kRowVoxels; ++n) {
    const std::int32_t pixel = places.pixel[n];
    measured_m[n] = pixel < 0 ? -1.0F : depth_m.data()[std::max(pixel, 0)];
  }
  const auto voxel_m = static_cast<float>(options.voxel_m);
  const auto blind_from_m = static_cast<float>(options.blind_from_m);
  const auto blind_to_m = static_cast<float>(options.blind_range_m);
  for (std::size_t n = 0; n < kRowVoxels; ++n) {
    const float margin_m = voxel_m + 2 * noise.SigmaM(measured_m[n]);
    counts.is_free[n] = measured_m[n] > depth_voxel_m[n] + margin_m ? 1 : 0;
    counts.is_blind[n] =
        (measured_m[n] == 0) & (depth_voxel_m[n] > blind_from_m) & (depth_voxel_m[n] < blind_to_m)
            ? 1
            : 0;
  }
}

inline void AddCounts(const std::array<std::uint8_t, kRowVoxels>& more, std::uint8_t* counts) {
  for (std::size_t n = 0; n < kRowVoxels; ++n) {
    const std::uint8_t was = counts[n];
    counts[n] = static_cast<std::uint8_t>(was + (was == 255 ? 0 : more[n]));
  }
}

Eigen::Vector3i IndexOf(const Eigen::Vector3d& p_world, double block_m) {
  return (p_world / block_m).array().floor().cast<int>();
}

}  // namespace

struct SpaceCarving::View {
  const DepthImage& depth_m;
  const PinholeCamera& camera;
  Eigen::Matrix4f camera_from_world;
  DepthNoise noise;
};

std::size_t SpaceCarving::Hash::operator()(const Eigen::Vector3i& index) const {
  std::uint64_t hash = 0;
  for (int axis = 0; axis < 3; ++axis) {
    hash = (hash ^ static_cast<std::uint32_t>(index[axis])) * 0x9E3779B97F4A7C15ULL;
    hash ^= hash >> 29U;
  }
  return hash;
}

// The blocks that rays of the image pass through, each once, in the order of the pixels.
std::vector<SpaceBlock*> SpaceCarving::Open(const DepthImage& depth_m,
                                            const PinholeCamera& camera,
                                            const Pose3& world_from_camera) {
  const double block_m = options_.voxel_m * SpaceBlock::kSide;
  std::vector<SpaceBlock*> touched;
  std::unordered_set<Eigen::Vector3i, Hash> known;
  const auto touch = [&](const Eigen::Vector3i& index) {
    if (!known.insert(index).second) return;
    const auto found = numbers_.find(index);
    if (found != numbers_.end()) {
      touched.push_back(blocks_[found->second].get());
    } else if (blocks_.size() < options_.max_blocks) {
      numbers_.emplace(index, blocks_.size());
      blocks_.push_back(std::make_unique<SpaceBlock>());
      blocks_.back()->index = index;
      touched.push_back(blocks_.back().get());
    }
  };
  for (int v = 0; v < depth_m.height(); v += kRayStride) {
    for (int u = 0; u < depth_m.width(); u += kRayStride) {
      const auto depth = static_cast<double>(depth_m(u, v));
      const Eigen::Vector3d ray = world_from_camera.rotation * camera.Ray(u, v);
      const double length = ray.norm();
      const double end_m =
          std::min(depth > 0 ? depth * length : options_.blind_range_m, options_.range_m);
      for (double at_m = 0; at_m < end_m; at_m += 0.5 * block_m)
        touch(IndexOf(world_from_camera.translation_m + at_m / length * ray, block_m));
      touch(IndexOf(world_from_camera.translation_m + end_m / length * ray, block_m));
    }
  }
  return touched;
}

DEEPSLAM_WIDE_VECTORS void SpaceCarving::Add(const View& view, SpaceBlock& block) const {
  const auto voxel = static_cast<float>(options_.voxel_m);
  const Eigen::Vector3f origin =
      (block.index.cast<double>() * (options_.voxel_m * SpaceBlock::kSide)).cast<float>().array() +
      0.5F * voxel;
  const Eigen::Vector3f step_z = view.camera_from_world.topRows<3>().col(2) * voxel;
  RowPlaces places;
  Row depth_voxel_m;
  RowCounts counts;
  std::size_t first = 0;
  for (int x = 0; x < SpaceBlock::kSide; ++x) {
    for (int y = 0; y < SpaceBlock::kSide; ++y, first += SpaceBlock::kSide) {
      const Eigen::Vector4f p_world(origin.x() + voxel * static_cast<float>(x),
                                    origin.y() + voxel * static_cast<float>(y),
                                    origin.z(),
                                    1.0F);
      const Eigen::Vector3f p_camera = view.camera_from_world.topRows<3>() * p_world;
      PlacePixels(view.camera, p_camera, step_z, places, depth_voxel_m);
      CountRow(view.depth_m, view.noise, options_, places, depth_voxel_m, counts);
      AddCounts(counts.is_free, block.passed.data() + first);
      AddCounts(counts.is_blind, block.blind.data() + first);
    }
  }
}

void SpaceCarving::Carve(const DepthImage& depth_m,
                         const PinholeCamera& camera,
                         const Pose3& world_from_camera,
                         const DepthNoise& noise) {
  const std::vector<SpaceBlock*> touched = Open(depth_m, camera, world_from_camera);
  const View view{depth_m, camera, world_from_camera.Inverse().Matrix().cast<float>(), noise};
  // Blocks a thread takes at a time; the result does not depend on it.
  constexpr std::size_t kBlocksPerChunk = 8;
  ParallelForChunks(touched.size(), kBlocksPerChunk, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) Add(view, *touched[n]);
  });
}

ObservedSpace SpaceCarving::Take() && {
  std::sort(blocks_.begin(), blocks_.end(), [](const auto& a, const auto& b) {
    return ObservedSpace::IsBefore(a->index, b->index);
  });
  std::vector<SpaceBlock> sorted;
  sorted.reserve(blocks_.size());
  for (std::unique_ptr<SpaceBlock>& block : blocks_) {
    sorted.push_back(*block);
    block.reset();
  }
  blocks_.clear();
  numbers_.clear();
  return {options_.voxel_m, std::move(sorted)};
}

}  // namespace deepslam::fuse
