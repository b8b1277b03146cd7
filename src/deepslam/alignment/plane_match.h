// Point-to-plane residual of a pair of points, and how it counts.
#pragma once

#include <cmath>

#include "deepslam/alignment/batch_columns.h"
#include "deepslam/geometry/depth_noise.h"

namespace deepslam::alignment {

// What surfaces are off by beside the noise: calibration, and what moves a little or is fixed to
// the camera. By their noise alone, things half a metre away would count a hundred times as much as
// a room, and a robot's own body in a tenth of the picture would hold the path where it began.
inline constexpr float kSystematicM = 0.005F;

// What a correspondence must fulfil, and the scale that its geometric residual is divided by.
struct CorrespondenceGates {
  float max_distance_m = 0.1F;  // along the optical axis of i
  float min_normal_cosine = 0.64F;
  float geometric_scale = 1.0F;       // standard deviation of residual / error(z)
  float systematic_m = kSystematicM;  // of each point, beside its noise
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
  // Of the noise and the systematic error of both points, 1/m: by what a residual counts.
  float inverse_sigma = 0;
  float normalised = 0;        // absolute, in standard deviations of both
  float normalised_noise = 0;  // absolute, in standard deviations of the noise alone
};

class PlaneMatcher {
 public:
  PlaneMatcher(const Eigen::Matrix3f& i_from_j,
               const DepthNoise& noise,
               const CorrespondenceGates& gates)
      : i_from_j_(i_from_j),
        base_m_(kSqrt2 * static_cast<float>(noise.base_m)),
        growth_per_m_(kSqrt2 * static_cast<float>(noise.growth_per_m)),
        squared_systematic_m2_(2 * gates.systematic_m * gates.systematic_m),
        min_cosine_(gates.min_normal_cosine) {}

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
    const float noise_m = base_m_ + growth_per_m_ * (p.z - 0.4F) * (p.z - 0.4F);
    match.inverse_sigma = 1.0F / std::sqrt(noise_m * noise_m + squared_systematic_m2_);
    match.normalised = std::abs(match.residual_m) * match.inverse_sigma;
    match.normalised_noise = std::abs(match.residual_m) / noise_m;
    return match;
  }

  [[nodiscard]] const Rotation& i_from_j() const { return i_from_j_; }

 private:
  static constexpr float kSqrt2 = 1.41421356F;  // a residual has the noise of two depths

  Rotation i_from_j_;
  float base_m_, growth_per_m_, squared_systematic_m2_, min_cosine_;
};

}  // namespace deepslam::alignment
