// How alike two shapes are, by the protocol of Pix3D (Sun et al. 2018) as its evaluation program
// computes it, so that figures can stand beside published ones.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/result.h"
#include "deepslam/eval/volume.h"

namespace deepslam::eval {

inline constexpr std::string_view kPix3dIou =
    "pix3d-iou: box of values >= 0.1, padded to a cube, trilinear to 32^3, threshold 0.01..0.49 by "
    "0.01, best mean over the set";
inline constexpr std::string_view kPix3dChamfer =
    "pix3d-cd: marching cubes at 0.1, 1024 points, box centred, longest side 1, mean nearest "
    "distance one way plus the other";

inline constexpr float kShapeThreshold = 0.1F;  // Pix3D's: what reaches it is solid
inline constexpr int kIouSize = 32;  // Pix3D's: samples a side at which shapes are compared
// 0.01, 0.02 ... 0.49: the program's range leaves its end of 0.50 out.
inline constexpr int kNumIouThresholds = 49;
inline constexpr int kNumChamferPoints = 1024;  // Pix3D's: drawn on either surface

// The shape at 32^3: cubes larger than 100 are max-pooled by 4 first; cropped to the box of values
// at or above 0.1; the cube round that box is sampled from its first to its last sample; zero
// outside the box. Errors: a volume that is no cube, is empty, or holds nothing at or above 0.1.
[[nodiscard]] Result<Volume> NormaliseForIou(const Volume& volume);

// Intersection over union at each threshold; 0 where both are empty. Both 32^3.
[[nodiscard]] std::vector<double> IouPerThreshold(const Volume& a, const Volume& b);

struct SetIou {
  double threshold = 0;      // with the best mean over the set, the lowest such
  double mean = 0;           // at that threshold
  std::vector<double> each;  // per pair, at that threshold
};
// Of pairs by IouPerThreshold. The mean of an empty set is 0.
[[nodiscard]] SetIou BestOverSet(std::span<const std::vector<double>> pairs);

// Points on the surface at 0.1: one at random in every triangle (in more rounds where there are
// fewer triangles than points), `kNumChamferPoints` of them drawn; box centred at the origin,
// longest side 1. A function of shape and seed alone. Errors: no surface.
[[nodiscard]] Result<std::vector<Eigen::Vector3d>> SampleForChamfer(const Volume& volume,
                                                                    std::uint64_t seed);

// Mean distance to the nearest point, from a to b plus from b to a. Neither is empty.
[[nodiscard]] double ChamferDistance(std::span<const Eigen::Vector3d> a,
                                     std::span<const Eigen::Vector3d> b);

}  // namespace deepslam::eval
