#include "deepslam/tracking/free_space.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace deepslam::tracking {
namespace {

// Seen through: this far behind, beside five standard deviations of the noise of the two.
constexpr float kMarginM = 0.05F;
constexpr float kMarginSigmas = 5.0F;  // chance alone takes 1 point in 2 million farther off

// The nearest depth about the pixel where the point falls; nothing where the frame has none of it.
std::optional<float> NearestAround(const PyramidLevel& level, const Eigen::Vector3d& p_camera) {
  const std::optional<Eigen::Vector2d> pixel = level.camera.Project(p_camera);
  if (!pixel || (pixel->array() < 0.5).any() || pixel->x() > level.camera.width - 1.5 ||
      pixel->y() > level.camera.height - 1.5)
    return std::nullopt;
  const int u = static_cast<int>(pixel->x() + 0.5);
  const int v = static_cast<int>(pixel->y() + 0.5);
  float nearest_m = std::numeric_limits<float>::infinity();
  for (int y = v - 1; y <= v + 1; ++y) {
    for (int x = u - 1; x <= u + 1; ++x)
      nearest_m =
          std::min(nearest_m, level.depth_m[static_cast<std::size_t>(y * level.camera.width + x)]);
  }
  return nearest_m > 0 ? std::optional(nearest_m) : std::nullopt;
}

// What an observer saw at the place where a surface of the frame stands.
enum class Space { kUnobserved, kFree, kOccupied };

class Observer {
 public:
  Observer(const PlacedPyramid& observer, const PlacedPyramid& frame, const DepthNoise& noise)
      : level_(FreeSpaceLevel(*observer.pyramid)),
        observer_from_frame_(observer.world_from_camera.Inverse() * frame.world_from_camera),
        noise_(noise.Scaled(std::max(observer.pyramid->noise_scale, frame.pyramid->noise_scale))) {}

  [[nodiscard]] Space At(const Eigen::Vector3d& p_frame) const {
    const Eigen::Vector3d p = observer_from_frame_ * p_frame;
    const std::optional<float> seen_m = NearestAround(level_, p);
    if (!seen_m) return Space::kUnobserved;
    const float z_m = static_cast<float>(p.z());
    const float margin_m =
        kMarginM + kMarginSigmas * std::hypot(noise_.SigmaM(z_m), noise_.SigmaM(*seen_m));
    if (*seen_m < z_m - margin_m) return Space::kUnobserved;  // hidden from there
    return *seen_m > z_m + margin_m ? Space::kFree : Space::kOccupied;
  }

 private:
  const PyramidLevel& level_;
  const Pose3 observer_from_frame_;
  const DepthNoise noise_;
};

double ShareViolating(std::span<const PlacedPyramid> frames,
                      std::span<const PlacedPyramid> observers,
                      const DepthNoise& noise) {
  std::ptrdiff_t num_violating = 0;
  std::ptrdiff_t num_observed = 0;
  for (const PlacedPyramid& frame : frames) {
    for (const PlacedPyramid& observer : observers) {
      const FreeSpaceMasks masks = ObserveFreeSpace(frame, {&observer, 1}, noise);
      num_violating += std::ranges::count(masks.violating, std::uint8_t{1});
      num_observed += std::ranges::count(masks.observed, std::uint8_t{1});
    }
  }
  return num_observed > 0 ? static_cast<double>(num_violating) / static_cast<double>(num_observed)
                          : 0;
}

}  // namespace

const PyramidLevel& FreeSpaceLevel(const FramePyramid& pyramid) {
  return pyramid.levels[NumAlignmentLevels(pyramid) - 1];
}

FreeSpaceMasks ObserveFreeSpace(const PlacedPyramid& frame,
                                std::span<const PlacedPyramid> observers,
                                const DepthNoise& noise) {
  const PyramidLevel& level = FreeSpaceLevel(*frame.pyramid);
  std::vector<Observer> last_first;
  for (auto observer = observers.rbegin(); observer != observers.rend(); ++observer)
    last_first.emplace_back(*observer, frame, noise);
  Mask violating(level.camera.width, level.camera.height);
  Mask observed = violating;
  for (int v = 0; v < violating.height(); ++v) {
    for (int u = 0; u < violating.width(); ++u) {
      const float z_m = level.depth_m[static_cast<std::size_t>(v * violating.width() + u)];
      if (!(z_m > 0)) continue;
      const Eigen::Vector3d p = static_cast<double>(z_m) * level.camera.Ray(u, v);
      Space space = Space::kUnobserved;
      for (std::size_t n = 0; n < last_first.size() && space == Space::kUnobserved; ++n)
        space = last_first[n].At(p);
      violating(u, v) = space == Space::kFree ? 1 : 0;
      observed(u, v) = space == Space::kUnobserved ? 0 : 1;
    }
  }
  return {std::move(violating), std::move(observed)};
}

double FreeSpaceViolation(std::span<const PlacedPyramid> a,
                          std::span<const PlacedPyramid> b,
                          const DepthNoise& noise) {
  return std::max(ShareViolating(a, b, noise), ShareViolating(b, a, noise));
}

}  // namespace deepslam::tracking
