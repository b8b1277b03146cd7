// The space that depth images looked through (space carving: Curless and Levoy 1996, section 4).
#pragma once

#include <cstddef>
#include <memory>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/image.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/depth_noise.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/observed_space.h"

namespace deepslam::fuse {

struct SpaceOptions {
  double voxel_m = 0.03;
  double range_m = 6.0;        // rays are followed this far from the camera, whatever they measured
  double blind_range_m = 4.0;  // nor is a pixel without depth evidence beyond: the surface may be
  double blind_from_m = 0.6;   // out of the sensor's reach, or nearer than it can measure
  std::size_t max_blocks = 40'000;  // of 8 KB; what lies beyond stays unseen
};

class SpaceCarving {
 public:
  explicit SpaceCarving(const SpaceOptions& options) : options_(options) {}

  // Adds an image with this noise: 0 is no depth, size as the camera's. Finite pose.
  void Carve(const DepthImage& depth_m,
             const PinholeCamera& camera,
             const Pose3& world_from_camera,
             const DepthNoise& noise);

  [[nodiscard]] ObservedSpace Take() &&;

 private:
  struct Hash {
    std::size_t operator()(const Eigen::Vector3i& index) const;
  };
  struct View;

  [[nodiscard]] std::vector<SpaceBlock*> Open(const DepthImage& depth_m,
                                              const PinholeCamera& camera,
                                              const Pose3& world_from_camera);
  void Add(const View& view, SpaceBlock& block) const;

  SpaceOptions options_;
  std::vector<std::unique_ptr<SpaceBlock>> blocks_;
  std::unordered_map<Eigen::Vector3i, std::size_t, Hash> numbers_;
};

}  // namespace deepslam::fuse
