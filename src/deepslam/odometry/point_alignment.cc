#include "deepslam/odometry/point_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace deepslam::odometry {
namespace {

constexpr int kBatch =
    512;  // residuals buffered before they are summed; the buffers stay in the L1 cache
constexpr int kLanes =
    8;  // partial sums per entry: one order of summation whatever the vector width
constexpr int kNumPairs = 27;  // upper triangle of a 6 x 6 matrix and a gradient of 6
constexpr float kNu = 5.0F;    // degrees of freedom of Student's t (Kerl et al. 2013)
constexpr float kInlierSigmas = 3.0F;
constexpr float kMadToSigma = 1.4826F;
constexpr float kMinGradient =
    1.5F;  // grey levels per pixel: below, the intensity says nothing about motion
constexpr float kBinsPerSigma = 16.0F;  // histogram of geometric residuals
constexpr float kBinsPerGrey = 4.0F;    // histogram of photometric residuals
constexpr std::size_t kNumBins = 512;

float StudentWeight(float normalised) { return (kNu + 1) / (kNu + normalised * normalised); }

class MedianHistogram {
 public:
  void Add(float absolute, float bins_per_unit) {
    const float bin = std::min(absolute * bins_per_unit, static_cast<float>(kNumBins - 1));
    ++bins_[static_cast<std::size_t>(bin)];
    ++count_;
  }
  [[nodiscard]] float Median(float bins_per_unit) const {
    std::uint32_t below = 0;
    for (std::size_t k = 0; k < kNumBins; ++k) {
      below += bins_[k];
      if (2 * below >= count_) return (static_cast<float>(k) + 0.5F) / bins_per_unit;
    }
    return static_cast<float>(kNumBins) / bins_per_unit;
  }

 private:
  std::array<std::uint32_t, kNumBins> bins_{};
  std::uint32_t count_ = 0;
};

// Rows of the weighted Jacobian, summed in batches.
class ResidualBatch {
 public:
  // `direction` is d residual / d p_i; a left perturbation moves p_i by t + r x p_i.
  void Add(
      float dx, float dy, float dz, float px, float py, float pz, float residual, float weight) {
    const std::size_t k = static_cast<std::size_t>(size_++);
    rows_[0][k] = dx;
    rows_[1][k] = dy;
    rows_[2][k] = dz;
    rows_[3][k] = py * dz - pz * dy;
    rows_[4][k] = pz * dx - px * dz;
    rows_[5][k] = px * dy - py * dx;
    rows_[6][k] = residual;
    weight_[k] = weight;
    if (size_ == kBatch) Flush();
  }

  void Finish(Matrix6d& hessian, Vector6d& gradient) {
    Flush();
    std::size_t pair = 0;
    for (int a = 0; a < 6; ++a) {
      for (int b = a; b < 6; ++b) hessian(a, b) = hessian(b, a) = sums_[pair++];
      gradient[a] = sums_[pair++];
    }
  }

 private:
  void Flush() {
    while (size_ % kLanes != 0) {
      const std::size_t k = static_cast<std::size_t>(size_++);
      for (auto& row : rows_) row[k] = 0;
      weight_[k] = 0;
    }
    std::size_t pair = 0;
    for (std::size_t a = 0; a < 6; ++a) {
      alignas(32) std::array<float, kBatch> weighted;
      for (std::size_t k = 0; k < static_cast<std::size_t>(size_); ++k)
        weighted[k] = weight_[k] * rows_[a][k];
      for (std::size_t b = a; b < 7; ++b) sums_[pair++] += Dot(weighted, rows_[b]);
    }
    size_ = 0;
  }

  [[nodiscard]] double Dot(const std::array<float, kBatch>& x,
                           const std::array<float, kBatch>& y) const {
    alignas(32) std::array<float, kLanes> lanes{};
    for (std::size_t k = 0; k < static_cast<std::size_t>(size_); k += kLanes) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) lanes[lane] += x[k + lane] * y[k + lane];
    }
    double sum = 0;
    for (const float lane : lanes) sum += static_cast<double>(lane);
    return sum;
  }

  int size_ = 0;
  alignas(32) std::array<std::array<float, kBatch>, 7> rows_;
  alignas(32) std::array<float, kBatch> weight_;
  std::array<double, kNumPairs> sums_{};
};

// Weighted line I_i = gain * I_j + bias.
class BrightnessFit {
 public:
  void Add(float source, float target, float weight) {
    const double w = static_cast<double>(weight), s = static_cast<double>(source),
                 t = static_cast<double>(target);
    sum_ += w;
    sum_s_ += w * s;
    sum_t_ += w * t;
    sum_ss_ += w * s * s;
    sum_st_ += w * s * t;
    sum_tt_ += w * t * t;
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
    bias = static_cast<float>((sum_t_ - slope * sum_s_) / sum_);
  }

 private:
  double sum_ = 0, sum_s_ = 0, sum_t_ = 0, sum_ss_ = 0, sum_st_ = 0, sum_tt_ = 0;
};

// A row of source points in frame i, and where they fall in its image.
struct MovedRow {
  explicit MovedRow(int width)
      : x(static_cast<std::size_t>(width)), y(x.size()), z(x.size()), u(x.size()), v(x.size()) {}
  std::vector<float> x, y, z, u, v;
};

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
      for (int u = gates_.stride / 2; u < j_.camera.width; u += gates_.stride) AddPoint(u, v, row);
    }
    Vector6d photometric_gradient;
    geometric_batch_.Finish(system_.hessian, system_.gradient);
    photometric_batch_.Finish(system_.photometric_hessian, photometric_gradient);
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

 private:
  // p_i = depth * R ray + t; R ray is linear along a row.
  void MoveRow(int v, MovedRow& row) const {
    const PinholeCamera& camera = j_.camera;
    const Eigen::Vector3f step = rotation_.col(0) / static_cast<float>(camera.fx);
    const Eigen::Vector3f start = rotation_ * camera.Ray(0, v).cast<float>();
    const float* depth = j_.depth_m.data() + static_cast<std::ptrdiff_t>(v) * camera.width;
    const float fx = static_cast<float>(i_.camera.fx), fy = static_cast<float>(i_.camera.fy);
    const float cx = static_cast<float>(i_.camera.cx), cy = static_cast<float>(i_.camera.cy);
    for (std::size_t u = 0; u < row.x.size(); ++u) {
      const float column = static_cast<float>(static_cast<int>(u));
      row.x[u] = depth[u] * (start.x() + column * step.x()) + translation_.x();
      row.y[u] = depth[u] * (start.y() + column * step.y()) + translation_.y();
      row.z[u] = depth[u] * (start.z() + column * step.z()) + translation_.z();
      // Points at or behind the camera are dropped by AddPoint; the bound keeps the division
      // finite.
      const float inverse_z = 1.0F / std::max(row.z[u], 0.05F);
      row.u[u] = fx * row.x[u] * inverse_z + cx;
      row.v[u] = fy * row.y[u] * inverse_z + cy;
    }
  }

  void AddPoint(int u, int v, const MovedRow& row) {
    const std::size_t k = static_cast<std::size_t>(u);
    const std::size_t source = static_cast<std::size_t>(v) * row.x.size() + k;
    if (!(j_.depth_m[source] > 0)) return;
    const SurfaceTexel& source_surface = j_.surface[source];
    const bool source_has_normal = source_surface.offset_m < 0;
    if (source_has_normal) ++system_.num_source;
    const PinholeCamera& camera = i_.camera;
    // One texel of border for the bilinear intensity.
    if (!(row.z[k] > 0.05F && row.u[k] >= 0 && row.v[k] >= 0 &&
          row.u[k] < static_cast<float>(camera.width - 1) &&
          row.v[k] < static_cast<float>(camera.height - 1))) {
      return;
    }
    if (source_has_normal) ++system_.num_inside;
    const std::size_t target =
        static_cast<std::size_t>(row.v[k] + 0.5F) * static_cast<std::size_t>(camera.width) +
        static_cast<std::size_t>(row.u[k] + 0.5F);
    const SurfaceTexel& surface = i_.surface[target];
    const bool both_have_normals = source_has_normal && surface.offset_m < 0;
    if (both_have_normals) ++system_.num_overlap;
    if (std::abs(row.z[k] - i_.depth_m[target]) > gates_.max_distance_m) return;
    if (both_have_normals) AddGeometric(surface, source_surface, row, k);
    // Outlines of objects have depth but no normal; their brightness still says where they are.
    if (photometric_) AddPhotometric(j_.intensity[source], row, k);
  }

  void AddGeometric(const SurfaceTexel& surface,
                    const SurfaceTexel& source_surface,
                    const MovedRow& row,
                    std::size_t k) {
    const Eigen::Vector3f normal =
        rotation_ * Eigen::Vector3f(source_surface.nx, source_surface.ny, source_surface.nz);
    const float cosine =
        normal.x() * surface.nx + normal.y() * surface.ny + normal.z() * surface.nz;
    if (cosine < gates_.min_normal_cosine) return;
    const float x = row.x[k], y = row.y[k], z = row.z[k];
    const float residual = surface.nx * x + surface.ny * y + surface.nz * z - surface.offset_m;
    const float sigma = 1.41421356F * noise_.SigmaM(z);  // both points are measured
    const float absolute = std::abs(residual) / sigma;
    ++system_.num_matched;
    geometric_histogram_.Add(absolute, kBinsPerSigma);
    if (absolute <= kInlierSigmas) {
      ++system_.num_inliers;
      system_.sum_squared_m2 += static_cast<double>(residual * residual);
    }
    const float scale = sigma * gates_.geometric_scale;
    const float weight = StudentWeight(residual / scale);
    system_.support += static_cast<double>(weight);
    const float information = weight / (scale * scale);
    if (gates_.cross_normals) {
      // a b^T + b a^T = ((a + b)(a + b)^T - (a - b)(a - b)^T) / 2.
      const Eigen::Vector3f sum(
          surface.nx + normal.x(), surface.ny + normal.y(), surface.nz + normal.z());
      const Eigen::Vector3f difference(
          surface.nx - normal.x(), surface.ny - normal.y(), surface.nz - normal.z());
      geometric_batch_.Add(sum.x(), sum.y(), sum.z(), x, y, z, 0, 0.25F * information);
      geometric_batch_.Add(
          difference.x(), difference.y(), difference.z(), x, y, z, 0, -0.25F * information);
    } else {
      geometric_batch_.Add(surface.nx, surface.ny, surface.nz, x, y, z, residual, information);
    }
  }

  void AddPhotometric(const IntensityTexel& source, const MovedRow& row, std::size_t k) {
    if (std::abs(source.du) + std::abs(source.dv) < kMinGradient) return;
    const std::size_t u0 = static_cast<std::size_t>(row.u[k]),
                      v0 = static_cast<std::size_t>(row.v[k]);
    const float a = row.u[k] - static_cast<float>(u0), b = row.v[k] - static_cast<float>(v0);
    const std::size_t width = static_cast<std::size_t>(i_.camera.width);
    const IntensityTexel* upper = i_.intensity.data() + v0 * width + u0;
    const IntensityTexel* lower = upper + width;
    const float w00 = (1 - a) * (1 - b), w10 = a * (1 - b), w01 = (1 - a) * b, w11 = a * b;
    const float value =
        w00 * upper[0].value + w10 * upper[1].value + w01 * lower[0].value + w11 * lower[1].value;
    const float du = w00 * upper[0].du + w10 * upper[1].du + w01 * lower[0].du + w11 * lower[1].du;
    const float dv = w00 * upper[0].dv + w10 * upper[1].dv + w01 * lower[0].dv + w11 * lower[1].dv;
    const float residual = value - (gates_.gain * source.value + gates_.bias);
    const float weight = StudentWeight(residual / gates_.photometric_scale);
    ++system_.num_photometric;
    photometric_histogram_.Add(std::abs(residual), kBinsPerGrey);
    brightness_.Add(source.value, value, weight);
    all_brightness_.Add(source.value, value, 1.0F);
    const float x = row.x[k], y = row.y[k], inverse_z = 1.0F / row.z[k];
    const float dx = du * static_cast<float>(i_.camera.fx) * inverse_z;
    const float dy = dv * static_cast<float>(i_.camera.fy) * inverse_z;
    const float dz = -(dx * x + dy * y) * inverse_z;
    photometric_batch_.Add(dx,
                           dy,
                           dz,
                           x,
                           y,
                           row.z[k],
                           residual,
                           weight / (gates_.photometric_scale * gates_.photometric_scale));
  }

  const PyramidLevel& i_;
  const PyramidLevel& j_;
  const AlignmentGates& gates_;
  const DepthNoise& noise_;
  const Eigen::Matrix3f rotation_;
  const Eigen::Vector3f translation_;
  const bool photometric_;
  AlignmentSystem system_;
  ResidualBatch geometric_batch_;
  ResidualBatch photometric_batch_;
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
