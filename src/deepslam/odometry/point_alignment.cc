#include "deepslam/odometry/point_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace deepslam::odometry {
namespace {

// Pairs are gathered and then computed on in batches, one array per quantity, so that the loops are
// vectorised; the arrays of a batch stay in the L1 cache.
constexpr std::size_t kBatch = 256;
constexpr std::size_t kLanes =
    8;  // partial sums per entry: one order of summation whatever the vector width
constexpr std::size_t kNumPairs = 27;  // upper triangle of a 6 x 6 matrix and a gradient of 6
constexpr float kNu = 5.0F;            // degrees of freedom of Student's t (Kerl et al. 2013)
constexpr float kInlierSigmas = 3.0F;
constexpr float kMadToSigma = 1.4826F;
constexpr float kMinGradient =
    1.5F;  // grey levels per pixel: below, the intensity says nothing about motion
constexpr float kMinPointZM = 0.05F;
constexpr float kMiddleGrey = 128.0F;
constexpr float kBinsPerSigma = 16.0F;  // histogram of geometric residuals
constexpr float kBinsPerGrey = 4.0F;    // histogram of photometric residuals
constexpr int kNumBins = 512;

struct alignas(32) Column : std::array<float, kBatch> {};

float StudentWeight(float normalised) { return (kNu + 1) / (kNu + normalised * normalised); }

// `size` is a multiple of kLanes, here and below.
double Sum(const Column& x, std::size_t size) {
  std::array<float, kLanes> lanes{};
  for (std::size_t k = 0; k < size; k += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) lanes[lane] += x[k + lane];
  }
  double sum = 0;
  for (const float lane : lanes) sum += static_cast<double>(lane);
  return sum;
}

double Dot(const Column& x, const Column& y, std::size_t size) {
  std::array<float, kLanes> lanes{};
  for (std::size_t k = 0; k < size; k += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) lanes[lane] += x[k + lane] * y[k + lane];
  }
  double sum = 0;
  for (const float lane : lanes) sum += static_cast<double>(lane);
  return sum;
}

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

  // (dx, dy, dz) is d residual / d p_i; a left perturbation moves p_i by t + r x p_i.
  void Set(std::size_t k, float dx, float dy, float dz, float px, float py, float pz, float r) {
    column[0][k] = dx;
    column[1][k] = dy;
    column[2][k] = dz;
    column[3][k] = py * dz - pz * dy;
    column[4][k] = pz * dx - px * dz;
    column[5][k] = px * dy - py * dx;
    column[6][k] = r;
  }
};

// J^T W J and J^T W r.
class NormalSums {
 public:
  void Add(const Rows& rows, const Column& weight, std::size_t size) {
    std::size_t pair = 0;
    Column weighted;
    for (std::size_t a = 0; a < 6; ++a) {
      for (std::size_t k = 0; k < size; ++k) weighted[k] = weight[k] * rows.column[a][k];
      for (std::size_t b = a; b < 7; ++b) sums_[pair++] += Dot(weighted, rows.column[b], size);
    }
  }

  void Finish(Matrix6d& hessian, Vector6d& gradient) const {
    std::size_t pair = 0;
    for (int a = 0; a < 6; ++a) {
      for (int b = a; b < 6; ++b) hessian(a, b) = hessian(b, a) = sums_[pair++];
      gradient[a] = sums_[pair++];
    }
  }

 private:
  std::array<double, kNumPairs> sums_{};
};

// Weighted line I_i = gain * I_j + bias.
class BrightnessFit {
 public:
  // Grey levels less kMiddleGrey, so that little is lost when means are subtracted.
  void Add(const Column& source, const Column& target, const Column& weight, std::size_t size) {
    Column weighted_source, weighted_target;
    for (std::size_t k = 0; k < size; ++k) {
      weighted_source[k] = weight[k] * source[k];
      weighted_target[k] = weight[k] * target[k];
    }
    sum_ += Sum(weight, size);
    sum_s_ += Sum(weighted_source, size);
    sum_t_ += Sum(weighted_target, size);
    sum_ss_ += Dot(weighted_source, source, size);
    sum_st_ += Dot(weighted_source, target, size);
    sum_tt_ += Dot(weighted_target, target, size);
  }
  [[nodiscard]] double Correlation() const {
    const double product = (sum_ss_ * sum_ - sum_s_ * sum_s_) * (sum_tt_ * sum_ - sum_t_ * sum_t_);
    return product > 0 ? (sum_st_ * sum_ - sum_s_ * sum_t_) / std::sqrt(product) : 0;
  }
  void Solve(float& gain, float& bias) const {
    const double variance = sum_ss_ * sum_ - sum_s_ * sum_s_;
    if (sum_ < 50 || variance <= 25 * sum_ * sum_) return;  // too few, or all of one brightness
    // Exposure changes within a factor of two between aligned frames; a fit beyond that is a wrong
    // alignment.
    const double slope = std::clamp((sum_st_ * sum_ - sum_s_ * sum_t_) / variance, 0.5, 2.0);
    gain = static_cast<float>(slope);
    bias = static_cast<float>((sum_t_ - slope * sum_s_) / sum_) + (1 - gain) * kMiddleGrey;
  }

 private:
  double sum_ = 0, sum_s_ = 0, sum_t_ = 0, sum_ss_ = 0, sum_st_ = 0, sum_tt_ = 0;
};

// A row of source points in frame i, and where they fall in its image: texel -1 where there is no
// depth, and outside.
struct MovedRow {
  explicit MovedRow(int width)
      : x(static_cast<std::size_t>(width)),
        y(x.size()),
        z(x.size()),
        u(x.size()),
        v(x.size()),
        texel(x.size()) {}
  std::vector<float> x, y, z, u, v;
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
           std::size_t u,
           const SurfaceTexel& target,
           const SurfaceTexel& source) {
    Set(row.x[u], row.y[u], row.z[u], target, source, 1.0F);
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
  Column counts;

  void Add(const MovedRow& row,
           std::size_t u,
           const IntensityTexel& source_texel,
           const IntensityTexel& target) {
    Set(row.x[u], row.y[u], row.z[u], source_texel, target, 1.0F);
  }
  void Fill() {
    while (size % kLanes != 0) Set(0, 0, 1, {}, {}, 0);
  }

 private:
  void Set(float px,
           float py,
           float pz,
           const IntensityTexel& source_texel,
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
    counts[size++] = count;
  }
};

// What the two frames see at a point p_i, in the axes of frame i: normals or brightness gradients.
struct CrossPair {
  Eigen::Vector3f point;
  Eigen::Vector3f target;
  Eigen::Vector3f source;
};

// Bilinear, between texel (u, v) rounded down and its neighbours.
IntensityTexel Interpolate(const PyramidLevel& level, float u, float v) {
  const std::size_t u0 = static_cast<std::size_t>(static_cast<int>(u));
  const std::size_t v0 = static_cast<std::size_t>(static_cast<int>(v));
  const float a = u - static_cast<float>(static_cast<int>(u));
  const float b = v - static_cast<float>(static_cast<int>(v));
  const std::size_t width = static_cast<std::size_t>(level.camera.width);
  const IntensityTexel* const upper = level.intensity.data() + v0 * width + u0;
  const IntensityTexel* const lower = upper + width;
  const float w00 = (1 - a) * (1 - b), w10 = a * (1 - b), w01 = (1 - a) * b, w11 = a * b;
  return {w00 * upper[0].value + w10 * upper[1].value + w01 * lower[0].value + w11 * lower[1].value,
          w00 * upper[0].du + w10 * upper[1].du + w01 * lower[0].du + w11 * lower[1].du,
          w00 * upper[0].dv + w10 * upper[1].dv + w01 * lower[0].dv + w11 * lower[1].dv};
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
    MovedRow row(j_.camera.width);
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
    const float* depth = j_.depth_m.data() + static_cast<std::ptrdiff_t>(v) * camera.width;
    const float fx = static_cast<float>(i_.camera.fx), fy = static_cast<float>(i_.camera.fy);
    const float cx = static_cast<float>(i_.camera.cx), cy = static_cast<float>(i_.camera.cy);
    const float x0 = start.x(), y0 = start.y(), z0 = start.z();
    const float x1 = step.x(), y1 = step.y(), z1 = step.z();
    const float tx = translation_.x(), ty = translation_.y(), tz = translation_.z();
    // One texel of border for the bilinear intensity.
    const float last_u = static_cast<float>(i_.camera.width - 1);
    const float last_v = static_cast<float>(i_.camera.height - 1);
    const std::int32_t width = i_.camera.width;
    float* const x = row.x.data();
    float* const y = row.y.data();
    float* const z = row.z.data();
    float* const to_u = row.u.data();
    float* const to_v = row.v.data();
    std::int32_t* const texel = row.texel.data();
    const int num_columns = camera.width;
#pragma GCC ivdep
    for (int u = 0; u < num_columns; ++u) {
      const float column = static_cast<float>(u);
      x[u] = depth[u] * (x0 + column * x1) + tx;
      y[u] = depth[u] * (y0 + column * y1) + ty;
      z[u] = depth[u] * (z0 + column * z1) + tz;
      // Points at or behind the camera fall nowhere; the bound keeps the division finite.
      const float bounded_z = z[u] > kMinPointZM ? z[u] : kMinPointZM;
      const float inverse_z = 1.0F / bounded_z;
      const float at_u = fx * x[u] * inverse_z + cx;
      const float at_v = fy * y[u] * inverse_z + cy;
      const bool inside = (depth[u] > 0) & (z[u] > kMinPointZM) & (at_u >= 0) & (at_v >= 0) &
                          (at_u < last_u) & (at_v < last_v);
      to_u[u] = inside ? at_u : 0.0F;
      to_v[u] = inside ? at_v : 0.0F;
      const std::int32_t nearest = static_cast<std::int32_t>(to_v[u] + 0.5F) * width +
                                   static_cast<std::int32_t>(to_u[u] + 0.5F);
      texel[u] = inside ? nearest : -1;
    }
  }

  void AddRow(int v, const MovedRow& row) {
    const std::size_t row_start = static_cast<std::size_t>(v) * row.x.size();
    const SurfaceTexel* const source_surface = j_.surface.data() + row_start;
    const IntensityTexel* const source_intensity =
        photometric_ ? j_.intensity.data() + row_start : nullptr;
    const SurfaceTexel* const target_surface = i_.surface.data();
    const float* const target_depth_m = i_.depth_m.data();
    const float max_distance_m = gates_.max_distance_m;
    const std::size_t stride = static_cast<std::size_t>(gates_.stride);
    int num_source = 0, num_inside = 0, num_overlap = 0;
    for (std::size_t u = stride / 2; u < row.x.size(); u += stride) {
      const SurfaceTexel& source = source_surface[u];
      const bool source_has_normal = source.offset_m < 0;
      num_source += source_has_normal ? 1 : 0;
      if (row.texel[u] < 0) continue;
      const std::size_t texel = static_cast<std::size_t>(row.texel[u]);
      const SurfaceTexel& target = target_surface[texel];
      const bool both_have_normals = source_has_normal & (target.offset_m < 0);
      num_inside += source_has_normal ? 1 : 0;
      num_overlap += both_have_normals ? 1 : 0;
      if (std::abs(row.z[u] - target_depth_m[texel]) > max_distance_m) continue;
      if (both_have_normals) AddGeometric(row, u, target, source);
      // Outlines of objects have depth but no normal; their brightness still says where they are.
      if (source_intensity != nullptr) AddPhotometric(row, u, source_intensity[u]);
    }
    system_.num_source += num_source;
    system_.num_inside += num_inside;
    system_.num_overlap += num_overlap;
  }

  void AddGeometric(const MovedRow& row,
                    std::size_t u,
                    const SurfaceTexel& target,
                    const SurfaceTexel& source) {
    geometric_.Add(row, u, target, source);
    if (geometric_.size == kBatch) FlushGeometric();
  }

  void AddPhotometric(const MovedRow& row, std::size_t u, const IntensityTexel& source) {
    if (std::abs(source.du) + std::abs(source.dv) < kMinGradient) return;
    photometric_pairs_.Add(row, u, source, Interpolate(i_, row.u[u], row.v[u]));
    if (photometric_pairs_.size == kBatch) FlushPhotometric();
  }

  void FlushGeometric() {
    geometric_.Fill();
    const GeometricPairs& pairs = geometric_;
    const std::size_t size = pairs.size;
    const float r00 = rotation_(0, 0), r01 = rotation_(0, 1), r02 = rotation_(0, 2);
    const float r10 = rotation_(1, 0), r11 = rotation_(1, 1), r12 = rotation_(1, 2);
    const float r20 = rotation_(2, 0), r21 = rotation_(2, 1), r22 = rotation_(2, 2);
    const float base = 1.41421356F * static_cast<float>(noise_.base_m);  // both points are measured
    const float growth = 1.41421356F * static_cast<float>(noise_.growth_per_m);
    const float inverse_scale = 1.0F / gates_.geometric_scale;
    const float min_cosine = gates_.min_normal_cosine;
    Column matched, inliers, squares, weights, informations;
    std::array<std::int32_t, kBatch> bins;
#pragma GCC ivdep
    for (std::size_t k = 0; k < size; ++k) {
      const float mx = pairs.source_nx[k], my = pairs.source_ny[k], mz = pairs.source_nz[k];
      const float nx = pairs.nx[k], ny = pairs.ny[k], nz = pairs.nz[k];
      const float x = pairs.x[k], y = pairs.y[k], z = pairs.z[k];
      const float cosine = (r00 * mx + r01 * my + r02 * mz) * nx +
                           (r10 * mx + r11 * my + r12 * mz) * ny +
                           (r20 * mx + r21 * my + r22 * mz) * nz;
      const float count = pairs.counts[k] * (cosine >= min_cosine ? 1.0F : 0.0F);
      const float residual = nx * x + ny * y + nz * z - pairs.offset_m[k];
      const float inverse_sigma = 1.0F / (base + growth * (z - 0.4F) * (z - 0.4F));
      const float normalised = std::abs(residual) * inverse_sigma;
      matched[k] = count;
      inliers[k] = count * (normalised <= kInlierSigmas ? 1.0F : 0.0F);
      squares[k] = residual * residual;
      bins[k] = Bin(normalised, kBinsPerSigma, count);
      weights[k] = count * StudentWeight(normalised * inverse_scale);
      informations[k] =
          weights[k] * (inverse_sigma * inverse_scale) * (inverse_sigma * inverse_scale);
      rows_.Set(k, nx, ny, nz, x, y, z, residual);
    }
    geometric_histogram_.Add(bins, size);
    system_.num_matched += static_cast<int>(Sum(matched, size));
    system_.num_inliers += static_cast<int>(Sum(inliers, size));
    system_.sum_squared_m2 += Dot(inliers, squares, size);
    system_.support += Sum(weights, size);
    if (gates_.judge_only) {
      geometric_.size = 0;
      return;
    }
    if (gates_.cross_frames) {
      AddCross(
          informations, size, [&](std::size_t k) { return NormalsAt(k); }, geometric_sums_);
    } else {
      geometric_sums_.Add(rows_, informations, size);
    }
    geometric_.size = 0;
  }

  // Sums of a b^T + b a^T = ((a + b)(a + b)^T - (a - b)(a - b)^T) / 2, halved. `pair_at` gives the
  // point of a match with the directions a and b that the two frames see there.
  template <typename PairAt, typename Sums>
  void AddCross(const Column& informations, std::size_t size, const PairAt& pair_at, Sums& sums) {
    for (const float sign : {1.0F, -1.0F}) {
      Column quarter;
      for (std::size_t k = 0; k < size; ++k) {
        const CrossPair pair = pair_at(k);
        const Eigen::Vector3f sum = pair.target + sign * pair.source;
        quarter[k] = sign * 0.25F * informations[k];
        rows_.Set(k, sum.x(), sum.y(), sum.z(), pair.point.x(), pair.point.y(), pair.point.z(), 0);
      }
      sums.Add(rows_, quarter, size);
    }
  }

  [[nodiscard]] CrossPair NormalsAt(std::size_t k) const {
    const GeometricPairs& pairs = geometric_;
    const Eigen::Vector3f source(pairs.source_nx[k], pairs.source_ny[k], pairs.source_nz[k]);
    return {{pairs.x[k], pairs.y[k], pairs.z[k]},
            {pairs.nx[k], pairs.ny[k], pairs.nz[k]},
            rotation_ * source};
  }

  [[nodiscard]] CrossPair GradientsAt(std::size_t k) const {
    const PhotometricPairs& pairs = photometric_pairs_;
    const Eigen::Vector3f p_i(pairs.x[k], pairs.y[k], pairs.z[k]);
    const Eigen::Vector3f p_j = rotation_.transpose() * (p_i - translation_);
    const Eigen::Vector3f target = BrightnessGradient(i_.camera, p_i, pairs.du[k], pairs.dv[k]);
    if (!(pairs.counts[k] > 0)) return {p_i, target, Eigen::Vector3f::Zero()};
    const Eigen::Vector3f source =
        BrightnessGradient(j_.camera, p_j, pairs.source_du[k], pairs.source_dv[k]);
    return {p_i, target, gates_.gain * (rotation_ * source)};
  }

  void FlushPhotometric() {
    photometric_pairs_.Fill();
    PhotometricPairs& pairs = photometric_pairs_;
    const std::size_t size = pairs.size;
    const float fx = static_cast<float>(i_.camera.fx), fy = static_cast<float>(i_.camera.fy);
    const float gain = gates_.gain, bias = gates_.bias;
    const float inverse_scale = 1.0F / gates_.photometric_scale;
    Column weights, informations;
    std::array<std::int32_t, kBatch> bins;
#pragma GCC ivdep
    for (std::size_t k = 0; k < size; ++k) {
      const float x = pairs.x[k], y = pairs.y[k], z = pairs.z[k];
      const float residual = pairs.value[k] - (gain * pairs.source[k] + bias);
      bins[k] = Bin(std::abs(residual), kBinsPerGrey, pairs.counts[k]);
      weights[k] = pairs.counts[k] * StudentWeight(residual * inverse_scale);
      informations[k] = weights[k] * inverse_scale * inverse_scale;
      pairs.source[k] -= kMiddleGrey;
      pairs.value[k] -= kMiddleGrey;
      const float inverse_z = 1.0F / z;
      const float dx = pairs.du[k] * fx * inverse_z;
      const float dy = pairs.dv[k] * fy * inverse_z;
      rows_.Set(k, dx, dy, -(dx * x + dy * y) * inverse_z, x, y, z, residual);
    }
    photometric_histogram_.Add(bins, size);
    system_.num_photometric += static_cast<int>(Sum(pairs.counts, size));
    brightness_.Add(pairs.source, pairs.value, weights, size);
    all_brightness_.Add(pairs.source, pairs.value, pairs.counts, size);
    if (gates_.judge_only) {
      pairs.size = 0;
      return;
    }
    if (gates_.cross_frames) {
      AddCross(
          informations, size, [&](std::size_t k) { return GradientsAt(k); }, photometric_sums_);
    } else {
      photometric_sums_.Add(rows_, informations, size);
    }
    pairs.size = 0;
  }

  // Derivative of the brightness by the point, in the axes of the camera that sees it at `p`.
  static Eigen::Vector3f BrightnessGradient(const PinholeCamera& camera,
                                            const Eigen::Vector3f& p,
                                            float du,
                                            float dv) {
    const float dx = du * static_cast<float>(camera.fx) / p.z();
    const float dy = dv * static_cast<float>(camera.fy) / p.z();
    return {dx, dy, -(dx * p.x() + dy * p.y()) / p.z()};
  }

  AlignmentSystem Conclude() {
    Vector6d photometric_gradient;
    geometric_sums_.Finish(system_.hessian, system_.gradient);
    photometric_sums_.Finish(system_.photometric_hessian, photometric_gradient);
    system_.hessian += system_.photometric_hessian;
    system_.gradient += photometric_gradient;
    system_.geometric_scale = system_.num_matched > 0
                                  ? kMadToSigma * geometric_histogram_.Median(kBinsPerSigma)
                                  : gates_.geometric_scale;
    system_.gain = gates_.gain;
    system_.bias = gates_.bias;
    system_.photometric_scale = gates_.photometric_scale;
    if (system_.num_photometric > 0) {
      system_.photometric_scale = kMadToSigma * photometric_histogram_.Median(kBinsPerGrey);
      brightness_.Solve(system_.gain, system_.bias);
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
  NormalSums geometric_sums_;
  NormalSums photometric_sums_;
  MedianHistogram geometric_histogram_;
  MedianHistogram photometric_histogram_;
  BrightnessFit brightness_;      // weighted
  BrightnessFit all_brightness_;  // every residual alike
};

}  // namespace

AlignmentSystem BuildAlignmentSystem(const PyramidLevel& i,
                                     const PyramidLevel& j,
                                     const Pose3& i_from_j,
                                     const AlignmentGates& gates,
                                     const DepthNoise& noise) {
  return SystemBuilder(i, j, i_from_j, gates, noise).Build();
}

}  // namespace deepslam::odometry
