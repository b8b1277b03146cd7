#include "deepslam/odometry/point_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "deepslam/core/wide_vectors.h"
#include "deepslam/odometry/batch_columns.h"
#include "deepslam/odometry/brightness_fit.h"
#include "deepslam/odometry/four_floats.h"

namespace deepslam::odometry {
namespace {

constexpr std::size_t kNumPairs = 27;  // upper triangle of a 6 x 6 matrix and a gradient of 6
constexpr float kNu = 5.0F;            // degrees of freedom of Student's t (Kerl et al. 2013)
constexpr float kInlierSigmas = 3.0F;
constexpr float kMadToSigma = 1.4826F;
constexpr float kMinPointZM = 0.05F;
constexpr float kBinsPerSigma = 16.0F;  // histogram of geometric residuals
constexpr float kBinsPerGrey = 4.0F;    // histogram of photometric residuals
constexpr int kNumBins = 512;

float StudentWeight(float normalised) { return (kNu + 1) / (kNu + normalised * normalised); }

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

// Three numbers of which the compiler keeps one each in a vector's lanes.
struct Triple {
  float x = 0, y = 0, z = 0;
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

using IndexColumn = std::array<std::int32_t, kBatch>;

// A batch of the source's points in frame i, and where they fall in its image.
struct MovedPoints {
  std::size_t begin = 0;  // in SourcePoints
  std::size_t size = 0;   // a multiple of kLanes
  Column x, y, z, u, v;
  IndexColumn is_inside;  // 1; 0 where there is no depth, and outside
  IndexColumn texel;      // the nearest one; 0 where it is not inside
};

// Some of a batch of points, by their place in it.
struct Selection {
  std::size_t size = 0;
  IndexColumn points;

  // Those whose `selected` is 1 and not 0; without a branch, which outlines would mislead.
  void Take(const IndexColumn& selected, std::size_t batch_size) {
    std::size_t count = 0;
    for (std::size_t k = 0; k < batch_size; ++k) {
      points[count] = static_cast<std::int32_t>(k);
      count += static_cast<std::size_t>(selected[k]);
    }
    size = count;
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

template <typename Point>
FourByFour FourOf(const Point& point, std::size_t k) {
  return {point(k), point(k + 1), point(k + 2), point(k + 3)};
}

// The first three numbers of four points, to where their columns go on; gives the fourth ones.
FourFloats ToColumns(const FourByFour& points, float* x, float* y, float* z) {
  const FourByFour columns = Transposed(points);
  WriteFour(columns.a, x);
  WriteFour(columns.b, y);
  WriteFour(columns.c, z);
  return columns.d;
}

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
    Column w00, w10, w01, w11;
    IndexColumn upper_left;
#pragma GCC ivdep
    for (std::size_t k = 0; k < size; ++k) {
      const std::int32_t u0 = static_cast<std::int32_t>(u[k]);
      const std::int32_t v0 = static_cast<std::int32_t>(v[k]);
      const float a = u[k] - static_cast<float>(u0), b = v[k] - static_cast<float>(v0);
      w00[k] = (1 - a) * (1 - b);
      w10[k] = a * (1 - b);
      w01[k] = (1 - a) * b;
      w11[k] = a * b;
      upper_left[k] = v0 * width + u0;
    }
    const auto at = [&](std::size_t k) {
      const float* const upper = &level.intensity[static_cast<std::size_t>(upper_left[k])].value;
      const float* const lower = upper + 3 * static_cast<std::ptrdiff_t>(width);
      // Of the image's last texel nothing follows: it is the end of the four before.
      const FourFloats last = FourFrom(lower + 2);
      return w00[k] * FourFrom(upper) + w10[k] * FourFrom(upper + 3) + w01[k] * FourFrom(lower) +
             w11[k] * __builtin_shufflevector(last, last, 1, 2, 3, 3);
    };
    for (std::size_t k = 0; k < size; k += 4) ToColumns(FourOf(at, k), &value[k], &du[k], &dv[k]);
  }
};

// What the two frames see at a point p_i, in the axes of frame i: normals or brightness gradients.
struct CrossPair {
  Triple point, target, source;
};

struct Rotation {
  explicit Rotation(const Eigen::Matrix3f& m)
      : r00(m(0, 0)),
        r01(m(0, 1)),
        r02(m(0, 2)),
        r10(m(1, 0)),
        r11(m(1, 1)),
        r12(m(1, 2)),
        r20(m(2, 0)),
        r21(m(2, 1)),
        r22(m(2, 2)) {}
  Triple operator*(const Triple& p) const {
    return {r00 * p.x + r01 * p.y + r02 * p.z,
            r10 * p.x + r11 * p.y + r12 * p.z,
            r20 * p.x + r21 * p.y + r22 * p.z};
  }
  float r00, r01, r02, r10, r11, r12, r20, r21, r22;
};

// A geometric pair's residual.
struct Match {
  float count = 0;  // 1 where the normals agree
  float residual_m = 0;
  float inverse_sigma = 0;
  float normalised = 0;
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
        noise_(noise),
        rotation_(i_from_j.rotation.toRotationMatrix().cast<float>()),
        translation_(i_from_j.translation_m.cast<float>()),
        photometric_(j.choice().photometric && !i.intensity.empty()) {}

  AlignmentSystem Build() {
    system_.num_source = j_.num_with_normal();
    auto row = j_.rows().begin();
    MovedPoints moved;
    for (moved.begin = 0; moved.begin < j_.size(); moved.begin += kBatch) {
      moved.size = std::min(kBatch, j_.size() - moved.begin);
      const std::size_t end = moved.begin + moved.size;
      for (; row != j_.rows().end() && row->begin < end; ++row) MoveRow(*row, moved);
      AddMoved(moved);
    }
    FlushGeometric();
    FlushPhotometric();
    return Conclude();
  }

 private:
  // p_i = depth * R ray + t; R ray is linear along a row.
  void MoveRow(const SourceRow& row, MovedPoints& moved) const {
    const PinholeCamera& camera = j_.level().camera;
    const Eigen::Vector3f step = rotation_.col(0) / static_cast<float>(camera.fx);
    const Eigen::Vector3f start = rotation_ * camera.Ray(0, row.v).cast<float>();
    const float fx = static_cast<float>(i_.camera.fx), fy = static_cast<float>(i_.camera.fy);
    const float cx = static_cast<float>(i_.camera.cx), cy = static_cast<float>(i_.camera.cy);
    const float x0 = start.x(), y0 = start.y(), z0 = start.z();
    const float x1 = step.x(), y1 = step.y(), z1 = step.z();
    const float tx = translation_.x(), ty = translation_.y(), tz = translation_.z();
    // One texel of border for the bilinear intensity.
    const float last_u = static_cast<float>(i_.camera.width - 1);
    const float last_v = static_cast<float>(i_.camera.height - 1);
    const std::int32_t width = i_.camera.width;
    const float* const columns = j_.column() + row.begin;
    const float* const depth = j_.depth_m() + row.begin;
    const std::size_t first = row.begin - moved.begin;
    float* const x = &moved.x[first];
    float* const y = &moved.y[first];
    float* const z = &moved.z[first];
    float* const to_u = &moved.u[first];
    float* const to_v = &moved.v[first];
    std::int32_t* const is_inside = &moved.is_inside[first];
    std::int32_t* const texel = &moved.texel[first];
    const std::size_t num_points = row.end - row.begin;
#pragma GCC ivdep
    for (std::size_t k = 0; k < num_points; ++k) {
      const float column = columns[k];
      x[k] = depth[k] * (x0 + column * x1) + tx;
      y[k] = depth[k] * (y0 + column * y1) + ty;
      z[k] = depth[k] * (z0 + column * z1) + tz;
      // Points at or behind the camera fall nowhere; the bound keeps the division finite.
      const float bounded_z = z[k] > kMinPointZM ? z[k] : kMinPointZM;
      const float inverse_z = 1.0F / bounded_z;
      const float at_u = fx * x[k] * inverse_z + cx;
      const float at_v = fy * y[k] * inverse_z + cy;
      const bool inside = (depth[k] > 0) & (z[k] > kMinPointZM) & (at_u >= 0) & (at_v >= 0) &
                          (at_u < last_u) & (at_v < last_v);
      to_u[k] = inside ? at_u : 0.0F;
      to_v[k] = inside ? at_v : 0.0F;
      is_inside[k] = inside ? 1 : 0;
      texel[k] = static_cast<std::int32_t>(to_v[k] + 0.5F) * width +
                 static_cast<std::int32_t>(to_u[k] + 0.5F);
    }
  }

  void AddMoved(const MovedPoints& moved) {
    Column target_offset_m, target_depth_m;
    for (std::size_t k = 0; k < moved.size; ++k) {
      const std::size_t texel = static_cast<std::size_t>(moved.texel[k]);
      target_offset_m[k] = i_.surface[texel].offset_m;
      target_depth_m[k] = i_.depth_m[texel];
    }
    Select(moved, target_offset_m, target_depth_m);
    AddPairs(moved, geometric_points_, geometric_, [&] { FlushGeometric(); });
    if (!photometric_) return;
    if (j_.choice().near) {
      photometric_points_.Keep(
          [&](std::size_t k) { return target_offset_m[k] < 0 || ShowsItself(i_, moved.texel[k]); });
    }
    AddPairs(moved, photometric_points_, photometric_pairs_, [&] { FlushPhotometric(); });
  }

  void Select(const MovedPoints& moved,
              const Column& target_offset_m,
              const Column& target_depth_m) {
    const std::int32_t* const has_normal = j_.has_normal() + moved.begin;
    const std::int32_t* const has_texture = j_.has_texture() + moved.begin;
    const float max_distance_m = gates_.max_distance_m;
    IndexColumn in_geometric, in_photometric;
    std::int32_t num_inside = 0, num_overlap = 0;
    for (std::size_t k = 0; k < moved.size; ++k) {
      const std::int32_t is_inside = moved.is_inside[k];
      const std::int32_t is_on_target = target_offset_m[k] < 0 ? is_inside : 0;
      const bool is_far = std::abs(moved.z[k] - target_depth_m[k]) > max_distance_m;
      const std::int32_t is_near = is_far ? 0 : is_inside;
      num_inside += has_normal[k] & is_inside;
      num_overlap += has_normal[k] & is_on_target;
      in_geometric[k] = is_near & has_normal[k] & is_on_target;
      in_photometric[k] = is_near & has_texture[k];
    }
    system_.num_inside += num_inside;
    system_.num_overlap += num_overlap;
    geometric_points_.Take(in_geometric, moved.size);
    photometric_points_.Take(in_photometric, moved.size);
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

  // Gives the match of the k-th geometric pair.
  [[nodiscard]] auto Matching() const {
    const Rotation rotation(rotation_);
    const float base = 1.41421356F * static_cast<float>(noise_.base_m);  // both points are measured
    const float growth = 1.41421356F * static_cast<float>(noise_.growth_per_m);
    const float min_cosine = gates_.min_normal_cosine;
    return [rotation, base, growth, min_cosine, &pairs = geometric_](std::size_t k) {
      const float nx = pairs.nx[k], ny = pairs.ny[k], nz = pairs.nz[k], z = pairs.z[k];
      const Triple m =
          rotation * Triple{pairs.source_nx[k], pairs.source_ny[k], pairs.source_nz[k]};
      const float cosine = m.x * nx + m.y * ny + m.z * nz;
      Match match;
      match.count = pairs.counts[k] * (cosine >= min_cosine ? 1.0F : 0.0F);
      match.residual_m = nx * pairs.x[k] + ny * pairs.y[k] + nz * z - pairs.offset_m[k];
      match.inverse_sigma = 1.0F / (base + growth * (z - 0.4F) * (z - 0.4F));
      match.normalised = std::abs(match.residual_m) * match.inverse_sigma;
      return match;
    };
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
    return [rotation = Rotation(rotation_), &pairs = geometric_](std::size_t k) {
      const Triple source{pairs.source_nx[k], pairs.source_ny[k], pairs.source_nz[k]};
      return CrossPair{{pairs.x[k], pairs.y[k], pairs.z[k]},
                       {pairs.nx[k], pairs.ny[k], pairs.nz[k]},
                       rotation * source};
    };
  }

  [[nodiscard]] auto GradientsOf() const {
    const Rotation i_from_j(rotation_), j_from_i(rotation_.transpose());
    const Triple origin{translation_.x(), translation_.y(), translation_.z()};
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
    if (gates_.judge_only) {
      JudgeGeometric();
    } else {
      SumGeometric();
    }
    geometric_.size = 0;
  }

  void JudgeGeometric() {
    const auto match_of = Matching();
    const std::size_t size = geometric_.size;
    const float inverse_scale = 1.0F / gates_.geometric_scale;
    Column weights;
#pragma GCC ivdep
    for (std::size_t k = 0; k < size; ++k) {
      const Match match = match_of(k);
      weights[k] = match.count * StudentWeight(match.normalised * inverse_scale);
    }
    system_.support += Sum(weights, size);
  }

  void SumGeometric() {
    const auto match_of = Matching();
    const GeometricPairs& pairs = geometric_;
    const std::size_t size = pairs.size;
    const float inverse_scale = 1.0F / gates_.geometric_scale;
    Column matched, inliers, squares, weights, informations;
    std::array<std::int32_t, kBatch> bins;
#pragma GCC ivdep
    for (std::size_t k = 0; k < size; ++k) {
      const Match match = match_of(k);
      matched[k] = match.count;
      inliers[k] = match.count * (match.normalised <= kInlierSigmas ? 1.0F : 0.0F);
      squares[k] = match.residual_m * match.residual_m;
      bins[k] = Bin(match.normalised, kBinsPerSigma, match.count);
      weights[k] = match.count * StudentWeight(match.normalised * inverse_scale);
      informations[k] = weights[k] * (match.inverse_sigma * inverse_scale) *
                        (match.inverse_sigma * inverse_scale);
      rows_.Set(k,
                {pairs.nx[k], pairs.ny[k], pairs.nz[k]},
                {pairs.x[k], pairs.y[k], pairs.z[k]},
                match.residual_m);
    }
    geometric_histogram_.Add(bins, size);
    system_.num_matched += static_cast<int>(Sum(matched, size));
    system_.num_inliers += static_cast<int>(Sum(inliers, size));
    system_.sum_squared_m2 += Dot(inliers, squares, size);
    system_.support += Sum(weights, size);
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
    if (!gates_.judge_only) SumPhotometric();
    PhotometricPairs& pairs = photometric_pairs_;
    for (std::size_t k = 0; k < pairs.size; ++k) {
      pairs.source[k] -= kMiddleGrey;
      pairs.value[k] -= kMiddleGrey;
    }
    system_.num_photometric += static_cast<int>(Sum(pairs.counts, pairs.size));
    if (!gates_.judge_only) {
      brightness_.Add(pairs.source, pairs.value, photometric_weights_, pairs.size);
      brightness_.AddFalloff(pairs.source, pairs.value, darker_, photometric_weights_, pairs.size);
    }
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
      system_.brightness_correlation = all_brightness_.Correlation();
    }
    return system_;
  }

  const PyramidLevel& i_;
  const SourcePoints& j_;
  const AlignmentGates& gates_;
  const DepthNoise& noise_;
  const Eigen::Matrix3f rotation_;
  const Eigen::Vector3f translation_;
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

}  // namespace deepslam::odometry
