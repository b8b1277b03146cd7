// Point-to-plane residual of a pair of points, and how it counts.
#pragma once

#include <cmath>

#include "deepslam/alignment/batch_columns.h"
#include "deepslam/geometry/depth_noise.h"

namespace deepslam::alignment {

// What a correspondence must fulfil, and the scale that its geometric residual is divided by.
struct CorrespondenceGates {
  float max_distance_m = 0.1F;  // along the optical axis of i
  float min_normal_cosine = 0.64F;
  float geometric_scale = 1.0F;  // standard deviation of residual / noise(z)
};

// Of a residual in standard deviations: Student's t with five degrees of freedom (Kerl et al.
// 2013).
inline float StudentWeight(float normalised) {
  constexpr float kNu = 5.0F;  // degrees of freedom
  return (kNu + 1) / (kNu + normalised * normalised);
}

struct PlaneMatch {
  float fits = 0;  // 1 where the normals do
  float residual_m = 0;
  float inverse_sigma = 0;  // of the noise of both points, 1/m
  float normalised = 0;     // absolute, in standard deviations
};

class PlaneMatcher {
 public:
  PlaneMatcher(const Eigen::Matrix3f& i_from_j, const DepthNoise& noise, float min_normal_cosine)
      : i_from_j_(i_from_j),
        base_m_(kSqrt2 * static_cast<float>(noise.base_m)),
        growth_per_m_(kSqrt2 * static_cast<float>(noise.growth_per_m)),
        min_cosine_(min_normal_cosine) {}

  // Point p in frame i, the reference's tangent plane there, the source's normal in frame j.
  PlaneMatch operator()(const Triple& p,
                        const Triple& normal,
                        float offset_m,
                        const Triple& source_normal) const {
    const Triple turned = i_from_j_ * source_normal;
    const float cosine = turned.x * normal.x + turned.y * normal.y + turned.z * normal.z;
    PlaneMatch match;
    match.fits = cosine >= min_cosine_ ? 1.0F : 0.0F;
    match.residual_m = normal.x * p.x + normal.y * p.y + normal.z * p.z - offset_m;
    match.inverse_sigma = 1.0F / (base_m_ + growth_per_m_ * (p.z - 0.4F) * (p.z - 0.4F));
    match.normalised = std::abs(match.residual_m) * match.inverse_sigma;
    return match;
  }

  [[nodiscard]] const Rotation& i_from_j() const { return i_from_j_; }

 private:
  static constexpr float kSqrt2 = 1.41421356F;  // a residual has the noise of two depths

  Rotation i_from_j_;
  float base_m_, growth_per_m_, min_cosine_;
};

}  // namespace deepslam::alignment
