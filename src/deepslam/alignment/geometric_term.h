// The point-to-plane term of a Gauss-Newton step: residuals in batches, their sums and spread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "deepslam/alignment/alignment_system.h"
#include "deepslam/alignment/batch_columns.h"
#include "deepslam/alignment/plane_match.h"
#include "deepslam/alignment/projected_points.h"
#include "deepslam/alignment/residual_sums.h"
#include "deepslam/alignment/source_points.h"
#include "deepslam/geometry/four_floats.h"

namespace deepslam::alignment {

// Points p_i and, for each, the reference's tangent plane and the source's normal in frame j.
struct GeometricPairs {
  std::size_t size = 0;
  Column x, y, z;
  IndexColumn reference;  // pixels
  IndexColumn source;     // in SourcePoints
  Column nx, ny, nz, offset_m;
  Column source_nx, source_ny, source_nz;
  Column counts;  // 1; 0 in what only fills the last lanes

  void Add(const ProjectedPoints& projected, std::span<const std::int32_t> points) {
    for (const std::int32_t point : points) {
      const std::size_t k = static_cast<std::size_t>(point);
      x[size] = projected.x[k];
      y[size] = projected.y[k];
      z[size] = projected.z[k];
      reference[size] = projected.pixel[k];
      source[size++] = static_cast<std::int32_t>(projected.begin + k);
    }
  }

  // Fills the last lanes, and the columns that are read from the frames.
  void Complete(const SurfacePixel* reference_surface, const PackedPixel* source_surface) {
    counts.fill(1.0F);
    for (; size % kLanes != 0; ++size) {
      x[size] = y[size] = counts[size] = 0;
      z[size] = 1;
      reference[size] = source[size] = 0;
    }
    const auto of_reference = [&](std::size_t k) {
      return FourFrom(&reference_surface[reference[k]].nx);
    };
    const auto of_source = [&](std::size_t k) { return FourFrom(&source_surface[source[k]].a); };
    for (std::size_t k = 0; k < size; k += 4) {
      WriteFour(ToColumns(FourOf(of_reference, k), &nx[k], &ny[k], &nz[k]), &offset_m[k]);
      ToColumns(FourOf(of_source, k), &source_nx[k], &source_ny[k], &source_nz[k]);
    }
  }
};

class GeometricTerm {
 public:
  // Keeps references to the frames, the gates and the room.
  GeometricTerm(const PyramidLevel& i,
                const SourcePoints& j,
                const PlaneMatcher& match_of,
                const AlignmentGates& gates,
                JacobianRoom& room)
      : i_(i), j_(j), match_of_(match_of), gates_(gates), room_(room) {}

  void Add(const ProjectedPoints& projected, std::span<const std::int32_t> points) {
    AddPairs(projected, points, pairs_, [&] { Flush(); });
  }

  void Flush() {
    pairs_.Complete(i_.surface.data(), j_.surface());
    Sum();
    pairs_.size = 0;
  }

  // Counts, Hessian, gradient and scale of a system that is empty before.
  void Finish(AlignmentSystem& system) const {
    system.num_matched = num_matched_;
    system.num_inliers = num_inliers_;
    system.sum_squared_m2 = sum_squared_m2_;
    if (gates_.cross_frames) {
      cross_sums_.Finish(system.hessian);
    } else {
      sums_.Finish(system.hessian, system.gradient);
    }
    system.geometric_scale =
        num_matched_ > 0 ? kMadToSigma * histogram_.Median(kBinsPerSigma) : gates_.geometric_scale;
  }

 private:
  static constexpr float kInlierSigmas = 3.0F;   // 99.7 % of normally distributed ones
  static constexpr float kBinsPerSigma = 16.0F;  // the median is known to a 32nd of one

  [[nodiscard]] auto NormalsOf() const {
    return [rotation = match_of_.i_from_j(), &pairs = pairs_](std::size_t k) {
      const Triple source{pairs.source_nx[k], pairs.source_ny[k], pairs.source_nz[k]};
      return CrossPair{{pairs.x[k], pairs.y[k], pairs.z[k]},
                       {pairs.nx[k], pairs.ny[k], pairs.nz[k]},
                       rotation * source};
    };
  }

  void Sum() {
    const PlaneMatcher match_of = match_of_;
    const GeometricPairs& pairs = pairs_;
    const std::size_t size = pairs.size;
    const float inverse_scale = 1.0F / gates_.geometric_scale;
    JacobianRows& rows = room_.rows;
    Column matched, inliers, squares, weights, informations;
    IndexColumn bins;
#pragma GCC ivdep
    for (std::size_t k = 0; k < size; ++k) {
      const Triple p{pairs.x[k], pairs.y[k], pairs.z[k]};
      const Triple normal{pairs.nx[k], pairs.ny[k], pairs.nz[k]};
      const PlaneMatch match =
          match_of(p,
                   normal,
                   pairs.offset_m[k],
                   {pairs.source_nx[k], pairs.source_ny[k], pairs.source_nz[k]});
      const float count = pairs.counts[k] * match.fits;
      matched[k] = count;
      inliers[k] = count * (match.normalised_noise <= kInlierSigmas ? 1.0F : 0.0F);
      squares[k] = match.residual_m * match.residual_m;
      bins[k] = MedianHistogram::Bin(match.normalised, kBinsPerSigma, count);
      weights[k] = count * StudentWeight(match.normalised * inverse_scale);
      informations[k] = weights[k] * (match.inverse_sigma * inverse_scale) *
                        (match.inverse_sigma * inverse_scale);
      rows.Set(k, normal, p, match.residual_m);
    }
    histogram_.Add(bins, size);
    num_matched_ += static_cast<int>(alignment::Sum(matched, size));
    num_inliers_ += static_cast<int>(alignment::Sum(inliers, size));
    sum_squared_m2_ += Dot(inliers, squares, size);
    if (gates_.cross_frames) {
      cross_sums_.Add(NormalsOf(), informations, size, room_);
    } else {
      sums_.Add(rows, informations, size);
    }
  }

  const PyramidLevel& i_;
  const SourcePoints& j_;
  const PlaneMatcher match_of_;
  const AlignmentGates& gates_;
  JacobianRoom& room_;
  GeometricPairs pairs_;
  int num_matched_ = 0;
  int num_inliers_ = 0;
  double sum_squared_m2_ = 0;
  NormalSums sums_;
  CrossSums cross_sums_;
  MedianHistogram histogram_;
};

}  // namespace deepslam::alignment
