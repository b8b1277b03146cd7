#include "deepslam/alignment/place_score.h"

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "deepslam/alignment/batch_columns.h"
#include "deepslam/alignment/photometric_fit.h"
#include "deepslam/alignment/plane_match.h"
#include "deepslam/alignment/projected_points.h"
#include "deepslam/core/check.h"
#include "deepslam/core/wide_vectors.h"
#include "deepslam/geometry/four_floats.h"

namespace deepslam::alignment {
namespace {

// Every point of a batch goes the whole way, and those that are not to count get no weight: few are
// left out, and picking the others takes longer.
class Scorer {
 public:
  Scorer(const PyramidLevel& i,
         const SourcePoints& j,
         const Pose3& i_from_j,
         const CorrespondenceGates& gates,
         const DepthNoise& noise)
      : i_(i),
        j_(j),
        gates_(gates),
        projector_(i.camera, j, i_from_j),
        match_of_(projector_.rotation(), noise, gates),
        photometric_(j.choice().photometric && !i.gradients.empty()) {}

  PlaceScore Run() {
    score_.num_source = j_.num_with_normal();
    projector_.ForBatches([&](const ProjectedPoints& projected) {
      ReadSurfaces(projected);
      AddGeometry(projected);
      if (photometric_) AddIntensity(projected);
    });
    score_.intensity_correlation = fit_.Correlation();
    return score_;
  }

 private:
  void ReadSurfaces(const ProjectedPoints& projected) {
    const PackedPixel* const source = j_.surface() + projected.begin;
    const auto of_reference = [&](std::size_t k) {
      return FourFrom(&i_.surface[Pixel(projected, k)].nx);
    };
    const auto of_source = [&](std::size_t k) { return FourFrom(&source[k].a); };
    for (std::size_t k = 0; k < projected.size; k += 4) {
      WriteFour(ToColumns(FourOf(of_reference, k), &nx_[k], &ny_[k], &nz_[k]), &offset_m_[k]);
      ToColumns(FourOf(of_source, k), &source_nx_[k], &source_ny_[k], &source_nz_[k]);
    }
    for (std::size_t k = 0; k < projected.size; ++k) depth_m_[k] = i_.depth_m[Pixel(projected, k)];
  }

  void AddGeometry(const ProjectedPoints& projected) {
    const std::int32_t* const has_normal = j_.has_normal() + projected.begin;
    const float inverse_scale = 1.0F / gates_.geometric_scale;
    const float max_distance_m = gates_.max_distance_m;
    const PlaneMatcher match_of = match_of_;
    std::int32_t num_overlap = 0;
    Column weights;
#pragma GCC ivdep
    for (std::size_t k = 0; k < projected.size; ++k) {
      const bool far = std::abs(projected.z[k] - depth_m_[k]) > max_distance_m;
      const std::int32_t is_near = far ? 0 : projected.is_inside[k];
      const std::int32_t overlaps = offset_m_[k] < 0 ? projected.is_inside[k] & has_normal[k] : 0;
      num_overlap += overlaps;
      const PlaneMatch match = match_of({projected.x[k], projected.y[k], projected.z[k]},
                                        {nx_[k], ny_[k], nz_[k]},
                                        offset_m_[k],
                                        {source_nx_[k], source_ny_[k], source_nz_[k]});
      const float weight = match.fits * StudentWeight(match.normalised * inverse_scale);
      weights[k] = (overlaps & is_near) != 0 ? weight : 0.0F;
      is_near_[k] = is_near;
    }
    score_.num_overlap += num_overlap;
    score_.support += Sum(weights, projected.size);
  }

  void AddIntensity(const ProjectedPoints& projected) {
    const std::int32_t* const has_texture = j_.has_texture() + projected.begin;
    const PackedPixel* const source = j_.intensity() + projected.begin;
    const std::int32_t width = i_.camera.width;
    const Bilinear at(projected.u, projected.v, width, projected.size);
    Column c00, c10, c01, c11, values, source_values, counts;
    for (std::size_t k = 0; k < projected.size; ++k) {
      const IntensityPixel* const upper = &i_.gradients[static_cast<std::size_t>(at.upper_left[k])];
      const IntensityPixel* const lower = upper + width;
      c00[k] = upper[0].value;
      c10[k] = upper[1].value;
      c01[k] = lower[0].value;
      c11[k] = lower[1].value;
      source_values[k] = source[k].a - kMiddleGrey;
    }
#pragma GCC ivdep
    for (std::size_t k = 0; k < projected.size; ++k) {
      values[k] = at.w00[k] * c00[k] + at.w10[k] * c10[k] + at.w01[k] * c01[k] +
                  at.w11[k] * c11[k] - kMiddleGrey;
      counts[k] = (is_near_[k] & has_texture[k]) != 0 ? 1.0F : 0.0F;
    }
    score_.num_photometric += static_cast<int>(Sum(counts, projected.size));
    fit_.Add(source_values, values, counts, projected.size);
  }

  static std::size_t Pixel(const ProjectedPoints& projected, std::size_t k) {
    return static_cast<std::size_t>(projected.pixel[k]);
  }

  const PyramidLevel& i_;
  const SourcePoints& j_;
  const CorrespondenceGates& gates_;
  const PointProjector projector_;
  const PlaneMatcher match_of_;
  const bool photometric_;
  // Of the batch.
  Column nx_, ny_, nz_, offset_m_, depth_m_;  // the reference's
  Column source_nx_, source_ny_, source_nz_;
  IndexColumn is_near_;
  PhotometricFit fit_;
  PlaceScore score_;
};

}  // namespace

DEEPSLAM_WIDE_VECTORS PlaceScore ScorePlace(const PyramidLevel& i,
                                            const SourcePoints& j,
                                            const Pose3& i_from_j,
                                            const CorrespondenceGates& gates,
                                            const DepthNoise& noise) {
  DEEPSLAM_CHECK(!j.choice().near, "places are scored by points for far off");
  return Scorer(i, j, i_from_j, gates, noise).Run();
}

}  // namespace deepslam::alignment
