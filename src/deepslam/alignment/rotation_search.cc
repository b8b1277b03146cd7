#include "deepslam/alignment/rotation_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Cholesky>

#include "deepslam/alignment/reference_pixels.h"
#include "deepslam/core/wide_vectors.h"

namespace deepslam::alignment {
namespace {

constexpr double kMaxShiftShare =
    0.5;  // of the image's width and height: about 30 degrees of pan for a Kinect
constexpr double kMinCorrelation = 0.3;  // of a shift that may be believed
constexpr int kMaxRefinements = 10;

struct Shift {
  int u = 0;
  int v = 0;
  double correlation = -1;
};

// Intensities centred on mid-grey, so that single precision does for the sums, and the sums over
// every upper left rectangle of them and of their squares.
class CentredImage {
 public:
  explicit CentredImage(const PyramidLevel& level)
      : width_(level.camera.width),
        height_(level.camera.height),
        values_(level.brightness.size()),
        sums_(static_cast<std::size_t>(width_ + 1) * static_cast<std::size_t>(height_ + 1)),
        squares_(sums_.size()) {
    for (int v = 0; v < height_; ++v) {
      double sum = 0, square = 0;
      for (int u = 0; u < width_; ++u) {
        const std::size_t at = static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
                               static_cast<std::size_t>(u);
        values_[at] = level.brightness(u, v) - 128.0F;
        const double value = static_cast<double>(values_[at]);
        sum += value;
        square += value * value;
        sums_[Corner(u + 1, v + 1)] = sums_[Corner(u + 1, v)] + sum;
        squares_[Corner(u + 1, v + 1)] = squares_[Corner(u + 1, v)] + square;
      }
    }
  }

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] const float* row(int v) const {
    return values_.data() + static_cast<std::ptrdiff_t>(v) * width_;
  }
  // Over columns [u0, u0 + width) and rows [v0, v0 + height).
  [[nodiscard]] double Sum(int u0, int v0, int width, int height) const {
    return Over(sums_, u0, v0, width, height);
  }
  [[nodiscard]] double SumOfSquares(int u0, int v0, int width, int height) const {
    return Over(squares_, u0, v0, width, height);
  }

 private:
  [[nodiscard]] std::size_t Corner(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_ + 1) +
           static_cast<std::size_t>(u);
  }
  [[nodiscard]] double Over(
      const std::vector<double>& sums, int u0, int v0, int width, int height) const {
    return sums[Corner(u0 + width, v0 + height)] - sums[Corner(u0, v0 + height)] -
           sums[Corner(u0 + width, v0)] + sums[Corner(u0, v0)];
  }

  int width_;
  int height_;
  std::vector<float> values_;
  std::vector<double> sums_;
  std::vector<double> squares_;
};

// In eight partial sums: one order whatever the vector width.
float Dot(const float* a, const float* b, int size) {
  constexpr int kLanes = 8;
  std::array<float, kLanes> lanes{};
  int k = 0;
  for (; k + kLanes <= size; k += kLanes) {
    for (int lane = 0; lane < kLanes; ++lane)
      lanes[static_cast<std::size_t>(lane)] += a[k + lane] * b[k + lane];
  }
  float sum = 0;
  for (; k < size; ++k) sum += a[k] * b[k];
  for (const float lane : lanes) sum += lane;
  return sum;
}

// Normalised cross-correlation of I_j(u, v) with I_i(u + shift).
double Correlation(const CentredImage& i, const CentredImage& j, int shift_u, int shift_v) {
  const int u0 = std::max(0, -shift_u), v0 = std::max(0, -shift_v);
  const int width = i.width() - std::abs(shift_u), height = i.height() - std::abs(shift_v);
  if (width < 1 || height < 1) return -1;
  double product = 0;
  for (int v = v0; v < v0 + height; ++v) {
    product += static_cast<double>(Dot(j.row(v) + u0, i.row(v + shift_v) + u0 + shift_u, width));
  }
  const double count = static_cast<double>(width) * height;
  const double mean_j = j.Sum(u0, v0, width, height) / count;
  const double mean_i = i.Sum(u0 + shift_u, v0 + shift_v, width, height) / count;
  const double var_j = j.SumOfSquares(u0, v0, width, height) / count - mean_j * mean_j;
  const double var_i =
      i.SumOfSquares(u0 + shift_u, v0 + shift_v, width, height) / count - mean_i * mean_i;
  // Below one grey level of spread there is nothing to correlate.
  if (!(var_i > 1 && var_j > 1)) return -1;
  return (product / count - mean_i * mean_j) / std::sqrt(var_i * var_j);
}

// Small overlaps correlate by chance: this shrinks them.
double OverlapFactor(const PinholeCamera& camera, int u, int v) {
  const double overlap = (1 - std::abs(u) / static_cast<double>(camera.width)) *
                         (1 - std::abs(v) / static_cast<double>(camera.height));
  return std::sqrt(overlap);
}

Shift BestShift(const PyramidLevel& i, const PyramidLevel& j) {
  // No correlation is above 1, but for rounding.
  constexpr double kMostCorrelation = 1.0001;
  const int max_u = static_cast<int>(kMaxShiftShare * i.camera.width);
  const int max_v = static_cast<int>(kMaxShiftShare * i.camera.height);
  const CentredImage centred_i(i), centred_j(j);
  const auto correlation = [&](int u, int v) {
    return Correlation(centred_i, centred_j, u, v) * OverlapFactor(i.camera, u, v);
  };
  // Images that follow each other leave few shifts that could be better than none.
  const double of_none = correlation(0, 0);
  Shift best;
  for (int v = -max_v; v <= max_v; ++v) {
    for (int u = -max_u; u <= max_u; ++u) {
      const double most = kMostCorrelation * OverlapFactor(i.camera, u, v);
      if (most < std::max(of_none, best.correlation)) continue;
      const double found = correlation(u, v);
      if (found > best.correlation) best = {u, v, found};
    }
  }
  return best;
}

// The rotation that carries the ray of j's image centre to where the shift puts it.
Eigen::Quaterniond RotationOfShift(const PinholeCamera& camera, const Shift& shift) {
  const Eigen::Vector3d from = camera.Ray(camera.cx, camera.cy).normalized();
  const Eigen::Vector3d to = camera.Ray(camera.cx + shift.u, camera.cy + shift.v).normalized();
  return Eigen::Quaterniond::FromTwoVectors(from, to);
}

struct RotationSystem {
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();  // its lower triangle
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  double sum_squared = 0;
  int count = 0;
};

// Numbers of a row of j's texels turned into camera i, one array per quantity so that loops are
// vectorised.
class TurnedRow {
 public:
  explicit TurnedRow(const PinholeCamera& camera)
      : camera_(camera), width_(static_cast<std::size_t>(camera.width)), target_(width_) {
    for (std::vector<float>& numbers : numbers_) numbers.resize(width_);
  }

  // Where the texels of row v lie in image i; target -1 outside it.
  void Turn(const Eigen::Quaterniond& i_from_j, int v) {
    const Eigen::Quaternionf turn = i_from_j.cast<float>();
    const float w = turn.w(), ax = turn.x(), ay = turn.y(), az = turn.z();
    const float fx = static_cast<float>(camera_.fx), fy = static_cast<float>(camera_.fy);
    const float cx = static_cast<float>(camera_.cx), cy = static_cast<float>(camera_.cy);
    const float right = static_cast<float>(camera_.width - 2);
    const float bottom = static_cast<float>(camera_.height - 2);
    const float y = (static_cast<float>(v) - cy) / fy;
    float *const rx = (*this)[kRayX], *const ry = (*this)[kRayY], *const rz = (*this)[kRayZ];
    float *const off_u = (*this)[kOffsetU], *const off_v = (*this)[kOffsetV];
    std::int32_t* const target = target_.data();
    const std::int32_t width = camera_.width;
#pragma GCC ivdep
    for (std::int32_t u = 1; u < width - 1; ++u) {
      const float x = (static_cast<float>(u) - cx) / fx;
      float tx = ay - az * y, ty = az * x - ax, tz = ax * y - ay * x;  // axis x ray
      tx += tx;
      ty += ty;
      tz += tz;
      rx[u] = x + w * tx + (ay * tz - az * ty);
      ry[u] = y + w * ty + (az * tx - ax * tz);
      rz[u] = 1.0F + w * tz + (ax * ty - ay * tx);
      const float at_u = fx * rx[u] / rz[u] + cx;
      const float at_v = fy * ry[u] / rz[u] + cy;
      const bool inside =
          (rz[u] > 1e-6F) & (at_u >= 1) & (at_v >= 1) & (at_u < right) & (at_v < bottom);
      const auto nearest_u = static_cast<std::int32_t>(inside ? at_u + 0.5F : 0.0F);
      const auto nearest_v = static_cast<std::int32_t>(inside ? at_v + 0.5F : 0.0F);
      off_u[u] = at_u - static_cast<float>(nearest_u);
      off_v[u] = at_v - static_cast<float>(nearest_v);
      target[u] = inside ? nearest_v * width + nearest_u : -1;
    }
  }

  // Residuals to first order from the nearest texel's centre, their weights and Jacobians.
  void Compare(const UnfilledVector<IntensityTexel>& i, const float* row_of_j) {
    float *const value = (*this)[kResidual], *const du = (*this)[kDu], *const dv = (*this)[kDv];
    for (std::size_t u = 1; u + 1 < width_; ++u) {
      const IntensityTexel& to = i[static_cast<std::size_t>(std::max(0, target_[u]))];
      value[u] = to.value;
      du[u] = to.du;
      dv[u] = to.dv;
    }
    const float fx = static_cast<float>(camera_.fx), fy = static_cast<float>(camera_.fy);
    float *const rx = (*this)[kRayX], *const ry = (*this)[kRayY], *const rz = (*this)[kRayZ];
    float *const off_u = (*this)[kOffsetU], *const off_v = (*this)[kOffsetV];
    float* const weight = (*this)[kWeight];
    const std::int32_t* const target = target_.data();
#pragma GCC ivdep
    for (std::size_t u = 1; u < width_ - 1; ++u) {
      const float residual = value[u] + du[u] * off_u[u] + dv[u] * off_v[u] - row_of_j[u];
      const float x = rx[u], y = ry[u], z = rz[u];
      const float gx = du[u] * fx / z, gy = dv[u] * fy / z;
      const float gz = -(gx * x + gy * y) / z;
      // Huber at 15 grey levels: exposure and parallax leave residuals of that order at this
      // resolution.
      const bool counts = target[u] >= 0;
      weight[u] = 15 / std::max(15.0F, std::abs(residual));
      value[u] = counts ? residual : 0.0F;
      rx[u] = counts ? y * gz - z * gy : 0.0F;  // ray x gradient
      ry[u] = counts ? z * gx - x * gz : 0.0F;
      rz[u] = counts ? x * gy - y * gx : 0.0F;
    }
  }

  // What Compare() found; of the Hessian the part below the diagonal and that itself.
  void AddTo(RotationSystem& system) const {
    const float *const jx = numbers_[kRayX].data(), *const jy = numbers_[kRayY].data(),
                       *const jz = numbers_[kRayZ].data();
    const float *const weights = numbers_[kWeight].data(), *const residuals =
                                                               numbers_[kResidual].data();
    RotationSystem sum = system;
    for (std::size_t u = 1; u + 1 < width_; ++u) {
      const double x = static_cast<double>(jx[u]), y = static_cast<double>(jy[u]);
      const double z = static_cast<double>(jz[u]), weight = static_cast<double>(weights[u]);
      const double residual = static_cast<double>(residuals[u]);
      const double wx = weight * x, wy = weight * y, wz = weight * z, wr = weight * residual;
      sum.hessian(0, 0) += wx * x;
      sum.hessian(1, 0) += wy * x;
      sum.hessian(2, 0) += wz * x;
      sum.hessian(1, 1) += wy * y;
      sum.hessian(2, 1) += wz * y;
      sum.hessian(2, 2) += wz * z;
      sum.gradient(0) += wr * x;
      sum.gradient(1) += wr * y;
      sum.gradient(2) += wr * z;
      sum.sum_squared += wr * residual;
      sum.count += target_[u] >= 0 ? 1 : 0;
    }
    system = sum;
  }

 private:
  // The ray becomes the Jacobian, the value the residual.
  enum Quantity : std::size_t {
    kRayX,
    kRayY,
    kRayZ,
    kOffsetU,
    kOffsetV,
    kResidual,
    kDu,
    kDv,
    kWeight,
    kNumQuantities
  };
  [[nodiscard]] float* operator[](Quantity quantity) { return numbers_[quantity].data(); }

  PinholeCamera camera_;
  std::size_t width_;
  std::vector<std::int32_t> target_;
  std::array<std::vector<float>, kNumQuantities> numbers_;
};

RotationSystem BuildRotationSystem(const UnfilledVector<IntensityTexel>& i,
                                   const PyramidLevel& j,
                                   const Eigen::Quaterniond& i_from_j,
                                   TurnedRow& row) {
  const PinholeCamera& camera = j.camera;
  RotationSystem system;
  for (int v = 1; v + 1 < camera.height; ++v) {
    row.Turn(i_from_j, v);
    row.Compare(i, j.brightness.row(v));
    row.AddTo(system);
  }
  return system;
}

}  // namespace

DEEPSLAM_WIDE_VECTORS std::optional<Eigen::Quaterniond> SearchRotation(const FramePyramid& i,
                                                                       const FramePyramid& j) {
  if (i.empty() || j.empty() || i.levels.size() != j.levels.size()) return std::nullopt;
  const PyramidLevel& coarse_i = i.levels.back();
  const PyramidLevel& coarse_j = j.levels.back();
  if (coarse_i.brightness.empty() || coarse_i.brightness.size() != coarse_j.brightness.size())
    return std::nullopt;
  const Shift shift = BestShift(coarse_i, coarse_j);
  if (shift.correlation < kMinCorrelation) return std::nullopt;
  Eigen::Quaterniond best = RotationOfShift(coarse_i.camera, shift);
  Eigen::Quaterniond rotation = best;
  double best_error = -1;
  const UnfilledVector<IntensityTexel> texels = WithDerivatives(coarse_i.brightness);
  TurnedRow row(coarse_i.camera);
  for (int n = 0; n < kMaxRefinements; ++n) {
    const RotationSystem system = BuildRotationSystem(texels, coarse_j, rotation, row);
    if (system.count < 30) break;
    const double error = system.sum_squared / system.count;
    if (best_error >= 0 && error >= best_error) break;
    best = rotation;
    best_error = error;
    const Eigen::Matrix3d damped =
        system.hessian + 1e-3 * system.hessian.trace() * Eigen::Matrix3d::Identity();
    const Eigen::Vector3d step = -damped.ldlt().solve(system.gradient);
    if (!step.allFinite() || step.norm() > 0.3) break;
    rotation = (RotationFromVector(step) * rotation).normalized();
  }
  return best;
}

}  // namespace deepslam::alignment
