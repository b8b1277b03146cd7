#include "deepslam/alignment/place_judgement.h"

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "deepslam/alignment/batch_columns.h"
#include "deepslam/alignment/bilinear.h"
#include "deepslam/alignment/brightness_fit.h"
#include "deepslam/alignment/four_floats.h"
#include "deepslam/alignment/moved_points.h"
#include "deepslam/alignment/plane_match.h"
#include "deepslam/core/check.h"
#include "deepslam/core/wide_vectors.h"

namespace deepslam::alignment {
namespace {

// Every point of a batch goes the whole way, and those that are not to count get no weight: few are
// left out, and picking the others takes longer.
class Judge {
 public:
  Judge(const PyramidLevel& i,
        const SourcePoints& j,
        const Pose3& i_from_j,
        const PlaceGates& gates,
        const DepthNoise& noise)
      : i_(i),
        j_(j),
        gates_(gates),
        mover_(i.camera, j, i_from_j),
        match_of_(mover_.rotation(), noise, gates.min_normal_cosine),
        photometric_(j.choice().photometric && !i.intensity.empty()) {}

  PlaceJudgement Run() {
    judgement_.num_source = j_.num_with_normal();
    mover_.ForBatches([&](const MovedPoints& moved) {
      ReadSurfaces(moved);
      AddGeometry(moved);
      if (photometric_) AddBrightness(moved);
    });
    judgement_.intensity_correlation = brightness_.Correlation();
    return judgement_;
  }

 private:
  void ReadSurfaces(const MovedPoints& moved) {
    const PackedTexel* const source = j_.surface() + moved.begin;
    const auto of_target = [&](std::size_t k) { return FourFrom(&i_.surface[Texel(moved, k)].nx); };
    const auto of_source = [&](std::size_t k) { return FourFrom(&source[k].a); };
    for (std::size_t k = 0; k < moved.size; k += 4) {
      WriteFour(ToColumns(FourOf(of_target, k), &nx_[k], &ny_[k], &nz_[k]), &offset_m_[k]);
      ToColumns(FourOf(of_source, k), &source_nx_[k], &source_ny_[k], &source_nz_[k]);
    }
    for (std::size_t k = 0; k < moved.size; ++k) depth_m_[k] = i_.depth_m[Texel(moved, k)];
  }

  void AddGeometry(const MovedPoints& moved) {
    const std::int32_t* const has_normal = j_.has_normal() + moved.begin;
    const float inverse_scale = 1.0F / gates_.geometric_scale;
    const float max_distance_m = gates_.max_distance_m;
    const PlaneMatcher match_of = match_of_;
    std::int32_t num_overlap = 0;
    Column weights;
#pragma GCC ivdep
    for (std::size_t k = 0; k < moved.size; ++k) {
      const bool far = std::abs(moved.z[k] - depth_m_[k]) > max_distance_m;
      const std::int32_t is_near = far ? 0 : moved.is_inside[k];
      const std::int32_t overlaps = offset_m_[k] < 0 ? moved.is_inside[k] & has_normal[k] : 0;
      num_overlap += overlaps;
      const PlaneMatch match = match_of({moved.x[k], moved.y[k], moved.z[k]},
                                        {nx_[k], ny_[k], nz_[k]},
                                        offset_m_[k],
                                        {source_nx_[k], source_ny_[k], source_nz_[k]});
      const float weight = match.agrees * StudentWeight(match.normalised * inverse_scale);
      weights[k] = (overlaps & is_near) != 0 ? weight : 0.0F;
      is_near_[k] = is_near;
    }
    judgement_.num_overlap += num_overlap;
    judgement_.support += Sum(weights, moved.size);
  }

  void AddBrightness(const MovedPoints& moved) {
    const std::int32_t* const has_texture = j_.has_texture() + moved.begin;
    const PackedTexel* const source = j_.intensity() + moved.begin;
    const std::int32_t width = i_.camera.width;
    const Bilinear at(moved.u, moved.v, width, moved.size);
    Column c00, c10, c01, c11, values, source_values, counts;
    for (std::size_t k = 0; k < moved.size; ++k) {
      const IntensityTexel* const upper = &i_.intensity[static_cast<std::size_t>(at.upper_left[k])];
      const IntensityTexel* const lower = upper + width;
      c00[k] = upper[0].value;
      c10[k] = upper[1].value;
      c01[k] = lower[0].value;
      c11[k] = lower[1].value;
      source_values[k] = source[k].a - kMiddleGrey;
    }
#pragma GCC ivdep
    for (std::size_t k = 0; k < moved.size; ++k) {
      values[k] = at.w00[k] * c00[k] + at.w10[k] * c10[k] + at.w01[k] * c01[k] +
                  at.w11[k] * c11[k] - kMiddleGrey;
      counts[k] = (is_near_[k] & has_texture[k]) != 0 ? 1.0F : 0.0F;
    }
    judgement_.num_photometric += static_cast<int>(Sum(counts, moved.size));
    brightness_.Add(source_values, values, counts, moved.size);
  }

  static std::size_t Texel(const MovedPoints& moved, std::size_t k) {
    return static_cast<std::size_t>(moved.texel[k]);
  }

  const PyramidLevel& i_;
  const SourcePoints& j_;
  const PlaceGates& gates_;
  const PointMover mover_;
  const PlaneMatcher match_of_;
  const bool photometric_;
  // Of the batch.
  Column nx_, ny_, nz_, offset_m_, depth_m_;  // the target's
  Column source_nx_, source_ny_, source_nz_;
  IndexColumn is_near_;
  BrightnessFit brightness_;
  PlaceJudgement judgement_;
};

}  // namespace

DEEPSLAM_WIDE_VECTORS PlaceJudgement JudgePlace(const PyramidLevel& i,
                                                const SourcePoints& j,
                                                const Pose3& i_from_j,
                                                const PlaceGates& gates,
                                                const DepthNoise& noise) {
  DEEPSLAM_CHECK(!j.choice().near, "places are judged by points for far off");
  return Judge(i, j, i_from_j, gates, noise).Run();
}

}  // namespace deepslam::alignment
