#include "deepslam/alignment/point_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "deepslam/alignment/batch_columns.h"
#include "deepslam/alignment/bilinear.h"
#include "deepslam/alignment/brightness_fit.h"
#include "deepslam/alignment/four_floats.h"
#include "deepslam/alignment/moved_points.h"
#include "deepslam/alignment/plane_match.h"
#include "deepslam/core/wide_vectors.h"

namespace deepslam::alignment {
namespace {

constexpr std::size_t kNumPairs = 27;  // upper triangle of a 6 x 6 matrix and a gradient of 6
constexpr float kInlierSigmas = 3.0F;
constexpr float kMadToSigma = 1.4826F;
constexpr float kBinsPerSigma = 16.0F;  // histogram of geometric residuals
constexpr float kBinsPerGrey = 4.0F;    // histogram of photometric residuals
constexpr int kNumBins = 512;

// Where a residual falls; one bin past the last for what does not count (0).
std::int32_t Bin(float absolute, float bins_per_unit, float counts) {
  const float last = static_cast<float>(kNumBins - 1);
  const float bin = absolute * bins_per_unit;
  const std::int32_t index = static_cast<std::int32_t>(bin < last ? bin : last);
  return counts > 0 ? index : kNumBins;
}

class MedianHistogram {
 public:
  void Add(const std::array<std::int32_t, kBatch>& bins, std::size_t size) {
    for (std::size_t k = 0; k < size; ++k) ++bins_[static_cast<std::size_t>(bins[k])];
  }
  [[nodiscard]] float Median(float bins_per_unit) const {
    std::uint32_t count = 0;
    for (std::size_t k = 0; k < kNumBins; ++k) count += bins_[k];
    std::uint32_t below = 0;
    for (std::size_t k = 0; k < kNumBins; ++k) {
      below += bins_[k];
      if (2 * below >= count) return (static_cast<float>(k) + 0.5F) / bins_per_unit;
    }
    return static_cast<float>(kNumBins) / bins_per_unit;
  }

 private:
  std::array<std::uint32_t, kNumBins + 1> bins_{};
};

// Rows of the Jacobian and the residual.
struct Rows {
  std::array<Column, 7> column;

  // d is d residual / d p; a left perturbation moves p, in frame i, by t + r x p.
  void Set(std::size_t k, const Triple& d, const Triple& p, float residual) {
    column[0][k] = d.x;
    column[1][k] = d.y;
    column[2][k] = d.z;
    column[3][k] = p.y * d.z - p.z * d.y;
    column[4][k] = p.z * d.x - p.x * d.z;
    column[5][k] = p.x * d.y - p.y * d.x;
    column[6][k] = residual;
  }
};

// J^T W J and J^T W r.
class NormalSums {
 public:
  void Add(const Rows& rows, const Column& weight, std::size_t size) {
    AddFrom<0>(rows, weight, size, sums_.data());
  }

  void Finish(Matrix6d& hessian, Vector6d& gradient) const {
    std::size_t pair = 0;
    for (int a = 0; a < 6; ++a) {
      for (int b = a; b < 6; ++b) hessian(a, b) = hessian(b, a) = sums_[pair++];
      gradient[a] = sums_[pair++];
    }
  }

 private:
  template <std::size_t kFirst>
  static void AddFrom(const Rows& rows, const Column& weight, std::size_t size, double* sums) {
    const Column* const first = &rows.column[kFirst];
    constexpr std::size_t kCount = 7 - kFirst;
    AddDots<kCount>(weight, *first, first, size, sums);
    if constexpr (kFirst < 5) AddFrom<kFirst + 1>(rows, weight, size, sums + kCount);
  }

  std::array<double, kNumPairs> sums_{};
};

// (A^T W B + B^T W A) / 2, of the rows' Jacobians.
class CrossSums {
 public:
  void Add(const Rows& rows_a, const Rows& rows_b, const Column& weight, std::size_t size) {
    for (std::size_t a = 0; a < 6; ++a)
      AddDots<6>(weight, rows_a.column[a], rows_b.column.data(), size, &sums_[6 * a]);
  }

  void Finish(Matrix6d& hessian) const {
    const Eigen::Map<const Matrix6d> sums(sums_.data());
    hessian = 0.5 * (sums + sums.transpose());
  }

 private:
  std::array<double, 36> sums_{};
};

// Some of a batch of points, by their place in it.
struct Selection {
  std::size_t size = 0;
  IndexColumn points;

  // Without a branch, which outlines would mislead.
  void Offer(std::size_t k, std::int32_t is_selected) {
    points[size] = static_cast<std::int32_t>(k);
    size += static_cast<std::size_t>(is_selected);
  }
  template <typename Kept>
  void Keep(const Kept& kept) {
    std::size_t count = 0;
    for (std::size_t n = 0; n < size; ++n) {
      const std::int32_t point = points[n];
      points[count] = point;
      count += kept(static_cast<std::size_t>(point)) ? 1 : 0;
    }
    size = count;
  }
  [[nodiscard]] std::span<const std::int32_t> span() const { return {points.data(), size}; }
};

// Points p_i and, for each, the target's tangent plane and the source's normal in frame j.
struct GeometricPairs {
  std::size_t size = 0;
  Column x, y, z;
  IndexColumn target;  // texels
  IndexColumn source;  // in SourcePoints
  Column nx, ny, nz, offset_m;
  Column source_nx, source_ny, source_nz;
  Column counts;  // 1; 0 in what only fills the last lanes

  void Add(const MovedPoints& moved, std::span<const std::int32_t> points) {
    for (const std::int32_t point : points) {
      const std::size_t k = static_cast<std::size_t>(point);
      x[size] = moved.x[k];
      y[size] = moved.y[k];
      z[size] = moved.z[k];
      target[size] = moved.texel[k];
      source[size++] = static_cast<std::int32_t>(moved.begin + k);
    }
  }
  // Fills the last lanes, and the columns that are read from the frames.
  void Complete(const SurfaceTexel* target_surface, const PackedTexel* source_surface) {
    counts.fill(1.0F);
    for (; size % kLanes != 0; ++size) {
      x[size] = y[size] = counts[size] = 0;
      z[size] = 1;
      target[size] = source[size] = 0;
    }
    const auto of_target = [&](std::size_t k) { return FourFrom(&target_surface[target[k]].nx); };
    const auto of_source = [&](std::size_t k) { return FourFrom(&source_surface[source[k]].a); };
    for (std::size_t k = 0; k < size; k += 4) {
      WriteFour(ToColumns(FourOf(of_target, k), &nx[k], &ny[k], &nz[k]), &offset_m[k]);
      ToColumns(FourOf(of_source, k), &source_nx[k], &source_ny[k], &source_nz[k]);
    }
  }
};

// Points p_i, the source's brightness and the target's, with its derivatives, at the point's pixel.
struct PhotometricPairs {
  std::size_t size = 0;
  Column x, y, z;
  Column u, v;               // in the target
  IndexColumn source_point;  // in SourcePoints
  Column source, source_du, source_dv, value, du, dv;
  Column source_rho2;
  Column counts;

  void Add(const MovedPoints& moved, std::span<const std::int32_t> points) {
    for (const std::int32_t point : points) {
      const std::size_t k = static_cast<std::size_t>(point);
      x[size] = moved.x[k];
      y[size] = moved.y[k];
      z[size] = moved.z[k];
      u[size] = moved.u[k];
      v[size] = moved.v[k];
      source_point[size++] = static_cast<std::int32_t>(moved.begin + k);
    }
  }
  void Complete(const PyramidLevel& target_level, const SourcePoints& points) {
    counts.fill(1.0F);
    for (; size % kLanes != 0; ++size) {
      x[size] = y[size] = u[size] = v[size] = counts[size] = 0;
      z[size] = 1;
      source_point[size] = 0;
    }
    Interpolate(target_level);
    const PackedTexel* const intensity = points.intensity();
    const auto of_source = [&](std::size_t k) { return FourFrom(&intensity[source_point[k]].a); };
    for (std::size_t k = 0; k < size; k += 4)
      ToColumns(FourOf(of_source, k), &source[k], &source_du[k], &source_dv[k]);
    const float* const rho2 = points.rho2();
    for (std::size_t k = 0; k < size; ++k) source_rho2[k] = rho2[source_point[k]];
  }

 private:
  // Bilinear, between texel (u, v) rounded down and its neighbours.
  void Interpolate(const PyramidLevel& level) {
    const std::int32_t width = level.camera.width;
    const Bilinear to(u, v, width, size);
    const auto at = [&](std::size_t k) {
      const float* const upper = &level.intensity[static_cast<std::size_t>(to.upper_left[k])].value;
      const float* const lower = upper + 3 * static_cast<std::ptrdiff_t>(width);
      // Of the image's last texel nothing follows: it is the end of the four before.
      const FourFloats last = FourFrom(lower + 2);
      return to.w00[k] * FourFrom(upper) + to.w10[k] * FourFrom(upper + 3) +
             to.w01[k] * FourFrom(lower) +
             to.w11[k] * __builtin_shufflevector(last, last, 1, 2, 3, 3);
    };
    for (std::size_t k = 0; k < size; k += 4) ToColumns(FourOf(at, k), &value[k], &du[k], &dv[k]);
  }
};

// What the two frames see at a point p_i, in the axes of frame i: normals or brightness gradients.
struct CrossPair {
  Triple point, target, source;
};

class SystemBuilder {
 public:
  SystemBuilder(const PyramidLevel& i,
                const SourcePoints& j,
                const Pose3& i_from_j,
                const AlignmentGates& gates,
                const DepthNoise& noise)
      : i_(i),
        j_(j),
        gates_(gates),
        mover_(i.camera, j, i_from_j),
        match_of_(mover_.rotation(), noise, gates.min_normal_cosine),
        photometric_(j.choice().photometric && !i.intensity.empty()) {}

  AlignmentSystem Build() {
    const auto stride = static_cast<std::size_t>(gates_.batch_stride);
    mover_.ForBatches([&](const MovedPoints& moved) { AddMoved(moved); }, stride);
    FlushGeometric();
    FlushPhotometric();
    return Conclude();
  }

 private:
  void AddMoved(const MovedPoints& moved) {
    Column sight_m;
    for (std::size_t k = 0; k < moved.size; ++k)
      sight_m[k] = i_.sight_m[static_cast<std::size_t>(moved.texel[k])];
    Select(moved, sight_m);
    AddPairs(moved, geometric_points_, geometric_, [&] { FlushGeometric(); });
    if (!photometric_) return;
    if (j_.choice().near) {
      photometric_points_.Keep(
          [&](std::size_t k) { return sight_m[k] > 0 || ShowsItself(i_, moved.texel[k]); });
    }
    AddPairs(moved, photometric_points_, photometric_pairs_, [&] { FlushPhotometric(); });
  }

  void Select(const MovedPoints& moved, const Column& sight_m) {
    const std::int32_t* const has_normal = j_.has_normal() + moved.begin;
    const std::int32_t* const has_texture = j_.has_texture() + moved.begin;
    const float max_distance_m = gates_.max_distance_m;
    IndexColumn in_geometric, in_photometric;
    std::int32_t num_source = 0, num_inside = 0, num_overlap = 0;
    for (std::size_t k = 0; k < moved.size; ++k) {
      const std::int32_t is_inside = moved.is_inside[k];
      const std::int32_t is_on_target = sight_m[k] > 0 ? is_inside : 0;
      const bool is_far = std::abs(moved.z[k] - std::abs(sight_m[k])) > max_distance_m;
      const std::int32_t is_near = is_far ? 0 : is_inside;
      num_source += has_normal[k];
      num_inside += has_normal[k] & is_inside;
      num_overlap += has_normal[k] & is_on_target;
      in_geometric[k] = is_near & has_normal[k] & is_on_target;
      in_photometric[k] = is_near & has_texture[k];
    }
    system_.num_source += num_source;
    system_.num_inside += num_inside;
    system_.num_overlap += num_overlap;
    geometric_points_.size = photometric_points_.size = 0;
    for (std::size_t k = 0; k < moved.size; ++k) {
      geometric_points_.Offer(k, in_geometric[k]);
      photometric_points_.Offer(k, in_photometric[k]);
    }
  }

  // To the batch, which `flush` empties whenever it is full.
  template <typename Pairs, typename Flush>
  static void AddPairs(const MovedPoints& moved,
                       const Selection& selection,
                       Pairs& pairs,
                       const Flush& flush) {
    std::span<const std::int32_t> points = selection.span();
    while (!points.empty()) {
      const std::size_t fitting = std::min(points.size(), kBatch - pairs.size);
      pairs.Add(moved, points.first(fitting));
      points = points.subspan(fitting);
      if (pairs.size == kBatch) flush();
    }
  }

  // Derivative of the brightness by the point, in the axes of the camera that sees it at `p`.
  static auto BrightnessGradient(const PinholeCamera& camera) {
    const float fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy);
    return [fx, fy](const Triple& p, float du, float dv) {
      const float inverse_z = 1.0F / (p.z > kMinPointZM ? p.z : kMinPointZM);
      const float dx = du * fx * inverse_z;
      const float dy = dv * fy * inverse_z;
      return Triple{dx, dy, -(dx * p.x + dy * p.y) * inverse_z};
    };
  }

  [[nodiscard]] auto NormalsOf() const {
    return [rotation = Rotation(mover_.rotation()), &pairs = geometric_](std::size_t k) {
      const Triple source{pairs.source_nx[k], pairs.source_ny[k], pairs.source_nz[k]};
      return CrossPair{{pairs.x[k], pairs.y[k], pairs.z[k]},
                       {pairs.nx[k], pairs.ny[k], pairs.nz[k]},
                       rotation * source};
    };
  }

  [[nodiscard]] auto GradientsOf() const {
    const Rotation i_from_j(mover_.rotation()), j_from_i(mover_.rotation().transpose());
    const Eigen::Vector3f& translation_m = mover_.translation_m();
    const Triple origin{translation_m.x(), translation_m.y(), translation_m.z()};
    const auto gradient_i = BrightnessGradient(i_.camera),
               gradient_j = BrightnessGradient(j_.level().camera);
    return [=, gain = gates_.gain, &pairs = photometric_pairs_](std::size_t k) {
      const Triple p_i{pairs.x[k], pairs.y[k], pairs.z[k]};
      const Triple p_j = j_from_i * Triple{p_i.x - origin.x, p_i.y - origin.y, p_i.z - origin.z};
      const Triple by_j = i_from_j * gradient_j(p_j, pairs.source_du[k], pairs.source_dv[k]);
      return CrossPair{p_i,
                       gradient_i(p_i, pairs.du[k], pairs.dv[k]),
                       {gain * by_j.x, gain * by_j.y, gain * by_j.z}};
    };
  }

  void FlushGeometric() {
    geometric_.Complete(i_.surface.data(), j_.surface());
    SumGeometric();
    geometric_.size = 0;
  }

  void SumGeometric() {
    const PlaneMatcher match_of = match_of_;
    const GeometricPairs& pairs = geometric_;
    const std::size_t size = pairs.size;
    const float inverse_scale = 1.0F / gates_.geometric_scale;
    Column matched, inliers, squares, weights, informations;
    std::array<std::int32_t, kBatch> bins;
#pragma GCC ivdep
    for (std::size_t k = 0; k < size; ++k) {
      const Triple p{pairs.x[k], pairs.y[k], pairs.z[k]};
      const Triple normal{pairs.nx[k], pairs.ny[k], pairs.nz[k]};
      const PlaneMatch match =
          match_of(p,
                   normal,
                   pairs.offset_m[k],
                   {pairs.source_nx[k], pairs.source_ny[k], pairs.source_nz[k]});
      const float count = pairs.counts[k] * match.agrees;
      matched[k] = count;
      inliers[k] = count * (match.normalised <= kInlierSigmas ? 1.0F : 0.0F);
      squares[k] = match.residual_m * match.residual_m;
      bins[k] = Bin(match.normalised, kBinsPerSigma, count);
      weights[k] = count * StudentWeight(match.normalised * inverse_scale);
      informations[k] = weights[k] * (match.inverse_sigma * inverse_scale) *
                        (match.inverse_sigma * inverse_scale);
      rows_.Set(k, normal, p, match.residual_m);
    }
    geometric_histogram_.Add(bins, size);
    system_.num_matched += static_cast<int>(Sum(matched, size));
    system_.num_inliers += static_cast<int>(Sum(inliers, size));
    system_.sum_squared_m2 += Dot(inliers, squares, size);
    if (gates_.cross_frames) {
      AddCross(informations, size, NormalsOf(), geometric_cross_);
    } else {
      geometric_sums_.Add(rows_, informations, size);
    }
  }

  // `pair_of` gives the point of a match with the directions that the two frames see there.
  template <typename PairOf>
  void AddCross(const Column& informations,
                std::size_t size,
                const PairOf& pair_of,
                CrossSums& sums) {
#pragma GCC ivdep
    for (std::size_t k = 0; k < size; ++k) {
      const CrossPair pair = pair_of(k);
      rows_.Set(k, pair.target, pair.point, 0);
      source_rows_.Set(k, pair.source, pair.point, 0);
    }
    sums.Add(rows_, source_rows_, informations, size);
  }

  void FlushPhotometric() {
    photometric_pairs_.Complete(i_, j_);
    SumPhotometric();
    PhotometricPairs& pairs = photometric_pairs_;
    for (std::size_t k = 0; k < pairs.size; ++k) {
      pairs.source[k] -= kMiddleGrey;
      pairs.value[k] -= kMiddleGrey;
    }
    system_.num_photometric += static_cast<int>(Sum(pairs.counts, pairs.size));
    brightness_.Add(pairs.source, pairs.value, photometric_weights_, pairs.size);
    brightness_.AddFalloff(pairs.source, pairs.value, darker_, photometric_weights_, pairs.size);
    all_brightness_.Add(pairs.source, pairs.value, pairs.counts, pairs.size);
    pairs.size = 0;
  }

  void SumPhotometric() {
    const PhotometricPairs& pairs = photometric_pairs_;
    const std::size_t size = pairs.size;
    const auto gradient = BrightnessGradient(i_.camera);
    const float gain = gates_.gain, bias = gates_.bias, falloff = gates_.falloff;
    const float inverse_scale = 1.0F / gates_.photometric_scale;
    Column& weights = photometric_weights_;
    Column informations;
    std::array<std::int32_t, kBatch> bins;
#pragma GCC ivdep
    for (std::size_t k = 0; k < size; ++k) {
      const Triple p{pairs.x[k], pairs.y[k], pairs.z[k]};
      const float rho2 = (p.x * p.x + p.y * p.y) / (p.z * p.z);
      darker_[k] = pairs.source[k] * (rho2 - pairs.source_rho2[k]);
      const float residual =
          pairs.value[k] - (gain * pairs.source[k] + bias + falloff * darker_[k]);
      bins[k] = Bin(std::abs(residual), kBinsPerGrey, pairs.counts[k]);
      weights[k] = pairs.counts[k] * StudentWeight(residual * inverse_scale);
      informations[k] = weights[k] * inverse_scale * inverse_scale;
      rows_.Set(k, gradient(p, pairs.du[k], pairs.dv[k]), p, residual);
    }
    photometric_histogram_.Add(bins, size);
    if (gates_.cross_frames) {
      AddCross(informations, size, GradientsOf(), photometric_cross_);
    } else {
      photometric_sums_.Add(rows_, informations, size);
    }
  }

  AlignmentSystem Conclude() {
    if (gates_.cross_frames) {
      geometric_cross_.Finish(system_.hessian);
      photometric_cross_.Finish(system_.photometric_hessian);
    } else {
      geometric_sums_.Finish(system_.hessian, system_.gradient);
      photometric_sums_.Finish(system_.photometric_hessian, system_.photometric_gradient);
    }
    CountForThoseBetween();
    system_.hessian += system_.photometric_hessian;
    system_.gradient += system_.photometric_gradient;
    system_.geometric_scale = system_.num_matched > 0
                                  ? kMadToSigma * geometric_histogram_.Median(kBinsPerSigma)
                                  : gates_.geometric_scale;
    system_.gain = gates_.gain;
    system_.bias = gates_.bias;
    system_.falloff = gates_.falloff;
    system_.photometric_scale = gates_.photometric_scale;
    if (system_.num_photometric > 0) {
      system_.photometric_scale = kMadToSigma * photometric_histogram_.Median(kBinsPerGrey);
      brightness_.Solve(system_.gain, system_.bias, system_.falloff);
      system_.intensity_correlation = all_brightness_.Correlation();
    }
    return system_;
  }

  void CountForThoseBetween() {
    for (int* const count : {&system_.num_source,
                             &system_.num_inside,
                             &system_.num_overlap,
                             &system_.num_matched,
                             &system_.num_inliers,
                             &system_.num_photometric})
      *count *= gates_.batch_stride;
    system_.sum_squared_m2 *= gates_.batch_stride;
    for (Matrix6d* const hessian : {&system_.hessian, &system_.photometric_hessian})
      *hessian *= gates_.batch_stride;
    for (Vector6d* const gradient : {&system_.gradient, &system_.photometric_gradient})
      *gradient *= gates_.batch_stride;
  }

  const PyramidLevel& i_;
  const SourcePoints& j_;
  const AlignmentGates& gates_;
  const PointMover mover_;
  const PlaneMatcher match_of_;
  const bool photometric_;
  AlignmentSystem system_;
  GeometricPairs geometric_;
  PhotometricPairs photometric_pairs_;
  Selection geometric_points_, photometric_points_;  // of the points moved last
  Rows rows_;
  Rows source_rows_;  // of what frame j sees
  Column photometric_weights_;
  Column darker_;  // BrightnessFit
  NormalSums geometric_sums_;
  NormalSums photometric_sums_;
  CrossSums geometric_cross_;
  CrossSums photometric_cross_;
  MedianHistogram geometric_histogram_;
  MedianHistogram photometric_histogram_;
  BrightnessFit brightness_;      // weighted
  BrightnessFit all_brightness_;  // every residual alike
};

}  // namespace

DEEPSLAM_WIDE_VECTORS AlignmentSystem BuildAlignmentSystem(const PyramidLevel& i,
                                                           const SourcePoints& j,
                                                           const Pose3& i_from_j,
                                                           const AlignmentGates& gates,
                                                           const DepthNoise& noise) {
  return SystemBuilder(i, j, i_from_j, gates, noise).Build();
}

}  // namespace deepslam::alignment
