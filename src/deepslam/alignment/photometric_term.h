// The photometric term of a Gauss-Newton step: residuals in batches, their sums and spread, and the
// fit of one frame's intensity to the other's.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "deepslam/alignment/alignment_system.h"
#include "deepslam/alignment/batch_columns.h"
#include "deepslam/alignment/photometric_fit.h"
#include "deepslam/alignment/plane_match.h"
#include "deepslam/alignment/projected_points.h"
#include "deepslam/alignment/residual_sums.h"
#include "deepslam/alignment/source_points.h"
#include "deepslam/geometry/four_floats.h"

namespace deepslam::alignment {

// Points p_i, the source's intensity and the reference's, with its derivatives, at the point's
// pixel.
struct PhotometricPairs {
  std::size_t size = 0;
  Column x, y, z;
  Column u, v;               // in the reference
  IndexColumn source_point;  // in SourcePoints
  Column source, source_du, source_dv, value, du, dv;
  Column source_rho2;
  Column counts;  // 1; 0 in what only fills the last lanes

  void Add(const ProjectedPoints& projected, std::span<const std::int32_t> points) {
    for (const std::int32_t point : points) {
      const std::size_t k = static_cast<std::size_t>(point);
      x[size] = projected.x[k];
      y[size] = projected.y[k];
      z[size] = projected.z[k];
      u[size] = projected.u[k];
      v[size] = projected.v[k];
      source_point[size++] = static_cast<std::int32_t>(projected.begin + k);
    }
  }

  // Fills the last lanes, and the columns that are read from the frames.
  void Complete(const PyramidLevel& reference_level, const SourcePoints& points) {
    counts.fill(1.0F);
    for (; size % kLanes != 0; ++size) {
      x[size] = y[size] = u[size] = v[size] = counts[size] = 0;
      z[size] = 1;
      source_point[size] = 0;
    }
    Interpolate(reference_level);
    const PackedPixel* const intensity = points.intensity();
    const auto of_source = [&](std::size_t k) { return FourFrom(&intensity[source_point[k]].a); };
    for (std::size_t k = 0; k < size; k += 4)
      ToColumns(FourOf(of_source, k), &source[k], &source_du[k], &source_dv[k]);
    const float* const rho2 = points.rho2();
    for (std::size_t k = 0; k < size; ++k) source_rho2[k] = rho2[source_point[k]];
  }

 private:
  // Bilinear, between pixel (u, v) rounded down and its neighbours.
  void Interpolate(const PyramidLevel& level) {
    const std::int32_t width = level.camera.width;
    const Bilinear to(u, v, width, size);
    const auto at = [&](std::size_t k) {
      const float* const upper = &level.gradients[static_cast<std::size_t>(to.upper_left[k])].value;
      const float* const lower = upper + 3 * static_cast<std::ptrdiff_t>(width);
      // Of the image's last pixel nothing follows: it is the end of the four before.
      const FourFloats last = FourFrom(lower + 2);
      return to.w00[k] * FourFrom(upper) + to.w10[k] * FourFrom(upper + 3) +
             to.w01[k] * FourFrom(lower) +
             to.w11[k] * __builtin_shufflevector(last, last, 1, 2, 3, 3);
    };
    for (std::size_t k = 0; k < size; k += 4) ToColumns(FourOf(at, k), &value[k], &du[k], &dv[k]);
  }
};

// Derivative of the intensity by the point, in the axes of the camera that sees it at `p`.
inline auto IntensityGradient(const PinholeCamera& camera) {
  const float fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy);
  return [fx, fy](const Triple& p, float du, float dv) {
    const float inverse_z = 1.0F / (p.z > kMinPointZM ? p.z : kMinPointZM);
    const float dx = du * fx * inverse_z;
    const float dy = dv * fy * inverse_z;
    return Triple{dx, dy, -(dx * p.x + dy * p.y) * inverse_z};
  };
}

class PhotometricTerm {
 public:
  // Keeps references to all of them.
  PhotometricTerm(const PyramidLevel& i,
                  const SourcePoints& j,
                  const PointProjector& projector,
                  const AlignmentGates& gates,
                  JacobianRoom& room)
      : i_(i), j_(j), projector_(projector), gates_(gates), room_(room) {}

  void Add(const ProjectedPoints& projected, std::span<const std::int32_t> points) {
    AddPairs(projected, points, pairs_, [&] { Flush(); });
  }

  void Flush() {
    pairs_.Complete(i_, j_);
    Sum();
    for (std::size_t k = 0; k < pairs_.size; ++k) {
      pairs_.source[k] -= kMiddleGrey;
      pairs_.value[k] -= kMiddleGrey;
    }
    num_residuals_ += static_cast<int>(alignment::Sum(pairs_.counts, pairs_.size));
    fit_.Add(pairs_.source, pairs_.value, weights_, pairs_.size);
    fit_.AddFalloff(pairs_.source, pairs_.value, darker_, weights_, pairs_.size);
    unweighted_fit_.Add(pairs_.source, pairs_.value, pairs_.counts, pairs_.size);
    pairs_.size = 0;
  }

  // Its own Hessian and gradient, the scale, and the fit, of a system that is empty before.
  void Finish(AlignmentSystem& system) const {
    if (gates_.cross_frames) {
      cross_sums_.Finish(system.photometric_hessian);
    } else {
      sums_.Finish(system.photometric_hessian, system.photometric_gradient);
    }
    system.num_photometric = num_residuals_;
    system.gain = gates_.gain;
    system.bias = gates_.bias;
    system.falloff = gates_.falloff;
    system.photometric_scale = gates_.photometric_scale;
    if (num_residuals_ == 0) return;
    system.photometric_scale = kMadToSigma * histogram_.Median(kBinsPerGrey);
    fit_.Solve(system.gain, system.bias, system.falloff);
    system.intensity_correlation = unweighted_fit_.Correlation();
  }

 private:
  static constexpr float kBinsPerGrey = 4.0F;  // the median is known to an eighth of a grey level

  [[nodiscard]] auto GradientsOf() const {
    const Rotation i_from_j(projector_.rotation()), j_from_i(projector_.rotation().transpose());
    const Eigen::Vector3f& translation_m = projector_.translation_m();
    const Triple origin{translation_m.x(), translation_m.y(), translation_m.z()};
    const auto gradient_i = IntensityGradient(i_.camera),
               gradient_j = IntensityGradient(j_.level().camera);
    return [=, gain = gates_.gain, &pairs = pairs_](std::size_t k) {
      const Triple p_i{pairs.x[k], pairs.y[k], pairs.z[k]};
      const Triple p_j = j_from_i * Triple{p_i.x - origin.x, p_i.y - origin.y, p_i.z - origin.z};
      const Triple by_j = i_from_j * gradient_j(p_j, pairs.source_du[k], pairs.source_dv[k]);
      return CrossPair{p_i,
                       gradient_i(p_i, pairs.du[k], pairs.dv[k]),
                       {gain * by_j.x, gain * by_j.y, gain * by_j.z}};
    };
  }

  void Sum() {
    const PhotometricPairs& pairs = pairs_;
    const std::size_t size = pairs.size;
    const auto gradient = IntensityGradient(i_.camera);
    const float gain = gates_.gain, bias = gates_.bias, falloff = gates_.falloff;
    const float inverse_scale = 1.0F / gates_.photometric_scale;
    JacobianRows& rows = room_.rows;
    Column& weights = weights_;
    Column& darker = darker_;
    Column informations;
    IndexColumn bins;
#pragma GCC ivdep
    for (std::size_t k = 0; k < size; ++k) {
      const Triple p{pairs.x[k], pairs.y[k], pairs.z[k]};
      const float rho2 = (p.x * p.x + p.y * p.y) / (p.z * p.z);
      darker[k] = pairs.source[k] * (rho2 - pairs.source_rho2[k]);
      const float residual = pairs.value[k] - (gain * pairs.source[k] + bias + falloff * darker[k]);
      bins[k] = MedianHistogram::Bin(std::abs(residual), kBinsPerGrey, pairs.counts[k]);
      weights[k] = pairs.counts[k] * StudentWeight(residual * inverse_scale);
      informations[k] = weights[k] * inverse_scale * inverse_scale;
      rows.Set(k, gradient(p, pairs.du[k], pairs.dv[k]), p, residual);
    }
    histogram_.Add(bins, size);
    if (gates_.cross_frames) {
      cross_sums_.Add(GradientsOf(), informations, size, room_);
    } else {
      sums_.Add(rows, informations, size);
    }
  }

  const PyramidLevel& i_;
  const SourcePoints& j_;
  const PointProjector& projector_;
  const AlignmentGates& gates_;
  JacobianRoom& room_;
  PhotometricPairs pairs_;
  Column weights_;
  Column darker_;  // PhotometricFit::AddFalloff
  int num_residuals_ = 0;
  NormalSums sums_;
  CrossSums cross_sums_;
  MedianHistogram histogram_;
  PhotometricFit fit_;             // weighted
  PhotometricFit unweighted_fit_;  // every residual alike
};

}  // namespace deepslam::alignment
