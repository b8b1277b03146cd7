#include "deepslam/alignment/patch_zncc.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

namespace deepslam::alignment {
namespace {

constexpr int kPatchPx = 8;          // a tenth of the width of the level that is looked at
constexpr int kMinPatchPoints = 16;  // of a patch
// Standard deviation of intensity within patches, grey levels, that a camera's noise may leave.
constexpr double kNoise = 2;
constexpr double kLeastContrast = 0.5;  // over contrast and noise: as much as the noise
// On the same surface: so near along the ray, beside five standard deviations of the noise.
constexpr double kMarginM = 0.05;
constexpr double kMarginSigmas = 5;  // chance takes 1 in 2 million farther off

struct Sums {
  int count = 0;
  double a = 0, b = 0, aa = 0, ab = 0, bb = 0;

  void Add(double value_a, double value_b) {
    ++count;
    a += value_a;
    b += value_b;
    aa += value_a * value_a;
    ab += value_a * value_b;
    bb += value_b * value_b;
  }

  // About its means, and by its points and not by its contrast: one chair's outlines outweigh a
  // whole floor otherwise.
  void AddPatch(const Sums& patch) {
    const double patch_aa = patch.aa - patch.a * patch.a / patch.count;
    const double patch_ab = patch.ab - patch.a * patch.b / patch.count;
    const double patch_bb = patch.bb - patch.b * patch.b / patch.count;
    const double contrast = std::max(patch_aa, patch_bb) / patch.count + kNoise * kNoise;
    count += patch.count;
    aa += patch_aa / contrast;
    ab += patch_ab / contrast;
    bb += patch_bb / contrast;
  }
};

// Intensity of i where it sees the point.
std::optional<float> IntensityAt(const PyramidLevel& i,
                                 const Eigen::Vector3d& p,
                                 const DepthNoise& noise) {
  const std::optional<Eigen::Vector2d> pixel = i.camera.Project(p);
  if (!pixel || pixel->x() < 0 || pixel->y() < 0 || pixel->x() >= i.camera.width - 1 ||
      pixel->y() >= i.camera.height - 1)
    return std::nullopt;
  const int u = static_cast<int>(pixel->x());
  const int v = static_cast<int>(pixel->y());
  const std::size_t k = static_cast<std::size_t>(v * i.camera.width + u);
  const double seen_m = static_cast<double>(i.depth_m[k]);
  const double margin_m =
      kMarginM + kMarginSigmas * static_cast<double>(noise.SigmaM(static_cast<float>(p.z())));
  if (!(seen_m > 0) || std::abs(seen_m - p.z()) > margin_m) return std::nullopt;
  const auto fu = static_cast<float>(pixel->x() - u);
  const auto fv = static_cast<float>(pixel->y() - v);
  const std::size_t below = k + static_cast<std::size_t>(i.camera.width);
  const float* const intensity = i.intensity.data();
  return (1 - fv) * ((1 - fu) * intensity[k] + fu * intensity[k + 1]) +
         fv * ((1 - fu) * intensity[below] + fu * intensity[below + 1]);
}

// Of the patch of j at (u0, v0).
Sums SumsOf(const PyramidLevel& j,
            const PyramidLevel& i,
            const Pose3& i_from_j,
            int u0,
            int v0,
            const DepthNoise& noise) {
  Sums sums;
  for (int v = v0; v < std::min(v0 + kPatchPx, j.camera.height); ++v) {
    for (int u = u0; u < std::min(u0 + kPatchPx, j.camera.width); ++u) {
      const std::size_t k = static_cast<std::size_t>(v * j.camera.width + u);
      const auto z_m = static_cast<double>(j.depth_m[k]);
      if (!(z_m > 0)) continue;
      const auto there = IntensityAt(i, i_from_j * (z_m * j.camera.Ray(u, v)), noise);
      if (there) sums.Add(static_cast<double>(j.intensity(u, v)), static_cast<double>(*there));
    }
  }
  return sums;
}

// Over points of j.
double ZnccOver(const FramePyramid& i,
                const FramePyramid& j,
                const Pose3& i_from_j,
                const DepthNoise& noise) {
  // Finer details do not look the same from other distances and under other angles.
  const std::size_t level = NumAlignmentLevels(j) - 1;
  const PyramidLevel& from = j.levels[level];
  const PyramidLevel& to = i.levels[level];
  if (from.intensity.empty() || to.intensity.empty()) return 1;
  Sums details;
  for (int v0 = 0; v0 < from.camera.height; v0 += kPatchPx) {
    for (int u0 = 0; u0 < from.camera.width; u0 += kPatchPx) {
      const Sums patch = SumsOf(from, to, i_from_j, u0, v0, noise);
      if (patch.count >= kMinPatchPoints) details.AddPatch(patch);
    }
  }
  if (std::max(details.aa, details.bb) <= kLeastContrast * details.count) return 1;
  return details.aa > 0 && details.bb > 0 ? details.ab / std::sqrt(details.aa * details.bb) : 0;
}

}  // namespace

double PatchZncc(const FramePyramid& i,
                 const FramePyramid& j,
                 const Pose3& i_from_j,
                 const DepthNoise& noise) {
  return std::min(ZnccOver(i, j, i_from_j, noise), ZnccOver(j, i, i_from_j.Inverse(), noise));
}

}  // namespace deepslam::alignment
