#include "deepslam/odometry/point_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "deepslam/core/wide_vectors.h"
#include "deepslam/odometry/batch_columns.h"
#include "deepslam/odometry/brightness_fit.h"

namespace deepslam::odometry {
namespace {

constexpr std::size_t kNumPairs = 27;  // upper triangle of a 6 x 6 matrix and a gradient of 6
constexpr float kNu = 5.0F;            // degrees of freedom of Student's t (Kerl et al. 2013)
constexpr float kInlierSigmas = 3.0F;
constexpr float kMadToSigma = 1.4826F;
constexpr float kMinGradient =
    1.5F;  // grey levels per pixel: below, the intensity says nothing about motion
constexpr float kMinPointZM = 0.05F;
// What is nearer by less than this share of the depth is the same surface.
constexpr float kSameSurface = 0.03F;
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

// Every stride-th point of a source row in frame i, and where it falls in its image: texel -1 where
// there is no depth, and outside.
struct MovedRow {
  MovedRow(int width, int source_stride)
      : stride(source_stride),
        first(source_stride / 2),
        depth_m(static_cast<std::size_t>((width - first + stride - 1) / stride)),
        x(depth_m.size()),
        y(x.size()),
        z(x.size()),
        u(x.size()),
        v(x.size()),
        rho2(x.size()),
        texel(x.size()) {}
  [[nodiscard]] int SourceColumn(int k) const { return first + k * stride; }
  int stride, first;
  std::vector<float> depth_m, x, y, z, u, v;
  std::vector<float> rho2;  // squared tangent of the ray's angle with the optical axis of frame j
  std::vector<std::int32_t> texel;
};

// Points p_i and, for each, the target's tangent plane and the source's normal in frame j.
struct GeometricPairs {
  std::size_t size = 0;
  Column x, y, z;
  Column nx, ny, nz, offset_m;
  Column source_nx, source_ny, source_nz;
  Column counts;  // 1; 0 in what only fills the last lanes

  void Add(const MovedRow& row,
           std::size_t k,
           const SurfaceTexel& target,
           const SurfaceTexel& source) {
    Set(row.x[k], row.y[k], row.z[k], target, source, 1.0F);
  }
  void Fill() {
    while (size % kLanes != 0) Set(0, 0, 1, {}, {}, 0);
  }

 private:
  void Set(float px,
           float py,
           float pz,
           const SurfaceTexel& target,
           const SurfaceTexel& source,
           float count) {
    x[size] = px;
    y[size] = py;
    z[size] = pz;
    nx[size] = target.nx;
    ny[size] = target.ny;
    nz[size] = target.nz;
    offset_m[size] = target.offset_m;
    source_nx[size] = source.nx;
    source_ny[size] = source.ny;
    source_nz[size] = source.nz;
    counts[size++] = count;
  }
};

// Points p_i, the source's brightness and the target's, with its derivatives, at the point's pixel.
struct PhotometricPairs {
  std::size_t size = 0;
  Column x, y, z;
  Column source, source_du, source_dv, value, du, dv;
  Column source_rho2;
  Column counts;

  void Add(const MovedRow& row,
           std::size_t k,
           const IntensityTexel& source_texel,
           const IntensityTexel& target) {
    Set(row.x[k], row.y[k], row.z[k], source_texel, row.rho2[k], target, 1.0F);
  }
  void Fill() {
    while (size % kLanes != 0) Set(0, 0, 1, {}, 0, {}, 0);
  }

 private:
  void Set(float px,
           float py,
           float pz,
           const IntensityTexel& source_texel,
           float rho2,
           const IntensityTexel& target,
           float count) {
    x[size] = px;
    y[size] = py;
    z[size] = pz;
    source[size] = source_texel.value;
    source_du[size] = source_texel.du;
    source_dv[size] = source_texel.dv;
    value[size] = target.value;
    du[size] = target.du;
    dv[size] = target.dv;
    source_rho2[size] = rho2;
    counts[size++] = count;
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

// Four numbers from `first` on, wherever they lie.
using FourFloats [[gnu::vector_size(4 * sizeof(float)), gnu::may_alias]] = float;
using FourAnywhere [[gnu::aligned(alignof(float))]] = FourFloats;

// Bilinear, between texel (u, v) rounded down and its neighbours.
IntensityTexel Interpolate(const PyramidLevel& level, float u, float v) {
  const std::size_t u0 = static_cast<std::size_t>(static_cast<int>(u));
  const std::size_t v0 = static_cast<std::size_t>(static_cast<int>(v));
  const float a = u - static_cast<float>(static_cast<int>(u));
  const float b = v - static_cast<float>(static_cast<int>(v));
  const std::size_t width = static_cast<std::size_t>(level.camera.width);
  const float* const upper = &level.intensity[v0 * width + u0].value;
  const float* const lower = &level.intensity[v0 * width + width + u0].value;
  const auto four = [](const float* first) -> const FourAnywhere& {
    return reinterpret_cast<const FourAnywhere&>(*first);
  };
  const float w00 = (1 - a) * (1 - b), w10 = a * (1 - b), w01 = (1 - a) * b, w11 = a * b;
  // Of the image's last texel nothing follows: it is the end of the four before.
  const FourFloats last = four(lower + 2);
  const FourFloats sum = w00 * four(upper) + w10 * four(upper + 3) + w01 * four(lower) +
                         w11 * __builtin_shufflevector(last, last, 1, 2, 3, 3);
  return {sum[0], sum[1], sum[2]};
}

// Whether what a texel without a normal shows is its own surface's brightness. Behind an outline
// the image is blurred with what is in front and moves with it; beside a gap of the depth it is not
// known who is in front.
bool ShowsItself(const PyramidLevel& level, std::ptrdiff_t texel) {
  const std::ptrdiff_t width = level.camera.width, height = level.camera.height;
  const std::ptrdiff_t u = texel % width, v = texel / width;
  const std::ptrdiff_t left = u > 0 ? -1 : 0, right = u + 1 < width ? 1 : 0;
  const float nearest_m = (1 - kSameSurface) * level.depth_m[static_cast<std::size_t>(texel)];
  for (std::ptrdiff_t y = std::max<std::ptrdiff_t>(0, v - 1); y <= std::min(height - 1, v + 1);
       ++y) {
    const float* const row_m = level.depth_m.data() + y * width + u;
    for (std::ptrdiff_t x = left; x <= right; ++x) {
      if (!(row_m[x] > 0) || row_m[x] < nearest_m) return false;
    }
  }
  return true;
}

class SystemBuilder {
 public:
  SystemBuilder(const PyramidLevel& i,
                const PyramidLevel& j,
                const Pose3& i_from_j,
                const AlignmentGates& gates,
                const DepthNoise& noise)
      : i_(i),
        j_(j),
        gates_(gates),
        noise_(noise),
        rotation_(i_from_j.rotation.toRotationMatrix().cast<float>()),
        translation_(i_from_j.translation_m.cast<float>()),
        photometric_(gates.photometric && !i.intensity.empty() && !j.intensity.empty()) {}

  AlignmentSystem Build() {
    MovedRow row(j_.camera.width, gates_.stride);
    for (int v = gates_.stride / 2; v < j_.camera.height; v += gates_.stride) {
      MoveRow(v, row);
      AddRow(v, row);
    }
    FlushGeometric();
    FlushPhotometric();
    return Conclude();
  }

 private:
  // p_i = depth * R ray + t; R ray is linear along a row.
  void MoveRow(int v, MovedRow& row) const {
    const PinholeCamera& camera = j_.camera;
    const Eigen::Vector3f step = rotation_.col(0) / static_cast<float>(camera.fx);
    const Eigen::Vector3f start = rotation_ * camera.Ray(0, v).cast<float>();
    const float* const source_m = j_.depth_m.data() + static_cast<std::ptrdiff_t>(v) * camera.width;
    const int num_points = static_cast<int>(row.x.size());
    for (int k = 0; k < num_points; ++k)
      row.depth_m[static_cast<std::size_t>(k)] = source_m[row.SourceColumn(k)];
    const float fx = static_cast<float>(i_.camera.fx), fy = static_cast<float>(i_.camera.fy);
    const float cx = static_cast<float>(i_.camera.cx), cy = static_cast<float>(i_.camera.cy);
    const float x0 = start.x(), y0 = start.y(), z0 = start.z();
    const float x1 = step.x(), y1 = step.y(), z1 = step.z();
    const float tx = translation_.x(), ty = translation_.y(), tz = translation_.z();
    // One texel of border for the bilinear intensity.
    const float last_u = static_cast<float>(i_.camera.width - 1);
    const float last_v = static_cast<float>(i_.camera.height - 1);
    const std::int32_t width = i_.camera.width;
    const int stride = row.stride, first = row.first;
    const Eigen::Vector2f ray = camera.Ray(0, v).head<2>().cast<float>();
    const float ray_x = ray.x(), ray_y2 = ray.y() * ray.y();
    const float ray_step = 1.0F / static_cast<float>(camera.fx);
    const float* const depth = row.depth_m.data();
    float* const x = row.x.data();
    float* const y = row.y.data();
    float* const z = row.z.data();
    float* const to_u = row.u.data();
    float* const to_v = row.v.data();
    float* const rho2 = row.rho2.data();
    std::int32_t* const texel = row.texel.data();
#pragma GCC ivdep
    for (int k = 0; k < num_points; ++k) {
      const float column = static_cast<float>(first + k * stride);
      const float tangent = ray_x + column * ray_step;
      rho2[k] = tangent * tangent + ray_y2;
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
      const std::int32_t nearest = static_cast<std::int32_t>(to_v[k] + 0.5F) * width +
                                   static_cast<std::int32_t>(to_u[k] + 0.5F);
      texel[k] = inside ? nearest : -1;
    }
  }

  void AddRow(int v, const MovedRow& row) {
    const std::ptrdiff_t row_start = static_cast<std::ptrdiff_t>(v) * j_.camera.width;
    const SurfaceTexel* const source_surface = j_.surface.data() + row_start;
    const IntensityTexel* const source_intensity =
        photometric_ ? j_.intensity.data() + row_start : nullptr;
    const SurfaceTexel* const target_surface = i_.surface.data();
    const float* const target_depth_m = i_.depth_m.data();
    const float max_distance_m = gates_.max_distance_m;
    int num_source = 0, num_inside = 0, num_overlap = 0;
    for (std::size_t k = 0; k < row.x.size(); ++k) {
      const int u = row.SourceColumn(static_cast<int>(k));
      const SurfaceTexel& source = source_surface[u];
      const bool source_has_normal = source.offset_m < 0;
      num_source += source_has_normal ? 1 : 0;
      if (row.texel[k] < 0) continue;
      const std::size_t texel = static_cast<std::size_t>(row.texel[k]);
      const SurfaceTexel& target = target_surface[texel];
      const bool both_have_normals = source_has_normal & (target.offset_m < 0);
      num_inside += source_has_normal ? 1 : 0;
      num_overlap += both_have_normals ? 1 : 0;
      if (std::abs(row.z[k] - target_depth_m[texel]) > max_distance_m) continue;
      if (both_have_normals) AddGeometric(row, k, target, source);
      // Outlines of objects have depth but no normal; their brightness still says where they are.
      if (source_intensity == nullptr || IsFlat(source_intensity[u])) continue;
      if (gates_.near && !source_has_normal && !ShowsItself(j_, row_start + u)) continue;
      if (gates_.near && !(target.offset_m < 0) && !ShowsItself(i_, row.texel[k])) continue;
      AddPhotometric(row, k, source_intensity[u]);
    }
    system_.num_source += num_source;
    system_.num_inside += num_inside;
    system_.num_overlap += num_overlap;
  }

  void AddGeometric(const MovedRow& row,
                    std::size_t k,
                    const SurfaceTexel& target,
                    const SurfaceTexel& source) {
    geometric_.Add(row, k, target, source);
    if (geometric_.size == kBatch) FlushGeometric();
  }

  static bool IsFlat(const IntensityTexel& texel) {
    return std::abs(texel.du) + std::abs(texel.dv) < kMinGradient;
  }

  void AddPhotometric(const MovedRow& row, std::size_t k, const IntensityTexel& source) {
    photometric_pairs_.Add(row, k, source, Interpolate(i_, row.u[k], row.v[k]));
    if (photometric_pairs_.size == kBatch) FlushPhotometric();
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
               gradient_j = BrightnessGradient(j_.camera);
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
    geometric_.Fill();
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
    photometric_pairs_.Fill();
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
  const PyramidLevel& j_;
  const AlignmentGates& gates_;
  const DepthNoise& noise_;
  const Eigen::Matrix3f rotation_;
  const Eigen::Vector3f translation_;
  const bool photometric_;
  AlignmentSystem system_;
  GeometricPairs geometric_;
  PhotometricPairs photometric_pairs_;
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
                                                           const PyramidLevel& j,
                                                           const Pose3& i_from_j,
                                                           const AlignmentGates& gates,
                                                           const DepthNoise& noise) {
  return SystemBuilder(i, j, i_from_j, gates, noise).Build();
}

}  // namespace deepslam::odometry
