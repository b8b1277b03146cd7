#include "deepslam/ground/floor_patches.h"

#include <algorithm>
#include <set>

#include "deepslam/core/angles.h"
#include "deepslam/core/order_statistics.h"
#include "deepslam/ground/plane_fit.h"

namespace deepslam::ground {
namespace {

constexpr float kPatchDepthM = 0.08F;  // noise, and a tilt of the vertical by 3 degrees
constexpr auto kMinPatchPoints = static_cast<std::size_t>(kMinPlanePoints);
constexpr std::size_t kMinPatchKeyframes = 2;  // one may have seen stray depth
constexpr double kMinPatchesM2 = 0.15;         // of all keyframes together: three of the smallest
constexpr double kMaxStrayShare = 0.02;  // of all points, below the ground: depth of mirror images

// Of the observations: the direction is that of table tops, the height that of the patches.
constexpr double kPatchAngleRad = 1.0 * kRadPerDeg;
constexpr double kPatchDistanceM = 0.03;  // drift between the keyframes that see them

// Heights above the camera of the points that face up, ascending.
std::vector<float> HeightsFacingUp(const GroundPoints& points, const Eigen::Vector3f& up) {
  std::vector<float> heights_m;
  for (const GroundPoint& point : points.points) {
    if (point.normal_camera.dot(up) >= static_cast<float>(kReidentifyCosine))
      heights_m.push_back(point.p_camera.dot(up));
  }
  std::ranges::sort(heights_m);
  return heights_m;
}

// Of the patches no farther above this one than levels are apart.
std::vector<std::size_t> LevelFrom(const FloorPatch& lowest, std::span<const FloorPatch> patches) {
  std::vector<std::size_t> level;
  for (std::size_t n = 0; n < patches.size(); ++n) {
    const double above_m = patches[n].height_m - lowest.height_m;
    if (above_m >= 0 && above_m <= GroundOptions::kLevelSeparation_m) level.push_back(n);
  }
  return level;
}

}  // namespace

std::optional<FloorPatch> LowestPatch(const GroundPoints& points,
                                      const PinholeCamera& camera,
                                      const Eigen::Vector3d& up_camera) {
  const std::vector<float> heights_m = HeightsFacingUp(points, up_camera.cast<float>());
  for (std::size_t begin = 0; begin + kMinPatchPoints <= heights_m.size();) {
    const auto end = static_cast<std::size_t>(
        std::ranges::upper_bound(heights_m, heights_m[begin] + kPatchDepthM) - heights_m.begin());
    if (end - begin < kMinPatchPoints) {
      ++begin;
      continue;
    }
    const auto middle_m = static_cast<double>(heights_m[begin + (end - begin) / 2]);
    const double area_m2 = CoveredAreaM2(points, camera, {up_camera, -middle_m});
    if (area_m2 >= GroundOptions::kMinArea_m2)
      return FloorPatch{0, 0, -middle_m, area_m2, static_cast<int>(end - begin)};
    begin = end;
  }
  return std::nullopt;
}

std::optional<PatchLevel> FindLowestLevel(std::span<const FloorPatch> patches,
                                          std::span<const KeyframeSample> samples,
                                          const Eigen::Vector3d& up_world,
                                          const GroundOptions& options) {
  std::vector<FloorPatch> order(patches.begin(), patches.end());
  std::ranges::stable_sort(order, {}, &FloorPatch::height_m);
  for (const FloorPatch& lowest : order) {
    PatchLevel level{0, LevelFrom(lowest, patches)};
    std::set<std::size_t> keyframes;
    std::vector<double> heights_m;
    std::vector<double> below_cameras_m;
    double area_m2 = 0;
    for (const std::size_t n : level.patches) {
      keyframes.insert(patches[n].keyframe);
      heights_m.push_back(patches[n].height_m);
      below_cameras_m.push_back(patches[n].below_camera_m);
      area_m2 += patches[n].area_m2;
    }
    if (keyframes.size() < kMinPatchKeyframes || area_m2 < kMinPatchesM2) continue;
    level.height_m = Median(heights_m);
    const double below_camera_m = Median(below_cameras_m);
    const double limit_m = level.height_m - GroundOptions::kLevelSeparation_m;
    if (below_camera_m < std::max(kLowCameraM, options.min_height_m) ||
        below_camera_m > options.max_height_m ||
        ShareBelow(samples, up_world, limit_m) > kMaxStrayShare)
      return std::nullopt;
    return level;
  }
  return std::nullopt;
}

Ground GroundOf(const PatchLevel& level,
                std::span<const FloorPatch> patches,
                std::span<const TrackedFrame> keyframes,
                const Eigen::Vector3d& up_world) {
  Ground ground;
  ground.plane_world = Plane{up_world, -level.height_m};
  for (const std::size_t n : level.patches) {
    const TrackedFrame& keyframe = keyframes[patches[n].keyframe];
    const Plane seen_world{up_world, -patches[n].height_m};
    ground.observations.push_back({keyframe.frame,
                                   Transformed(keyframe.world_from_camera.Inverse(), seen_world),
                                   InformationOf(kPatchAngleRad, kPatchDistanceM),
                                   patches[n].num_points});
  }
  return ground;
}

}  // namespace deepslam::ground
