#include "deepslam/alignment/rotation_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Cholesky>

#include "deepslam/alignment/image_shift.h"
#include "deepslam/alignment/reference_pixels.h"
#include "deepslam/core/wide_vectors.h"

namespace deepslam::alignment {
namespace {

constexpr double kMinShiftCorrelation = 0.3;  // of a shift that is accepted
constexpr int kMaxRefinements = 10;  // steps at most; they end where the error no longer falls
constexpr int kMinPixels = 30;       // fewer say nothing of three angles
// Share of the Hessian's trace on its diagonal: what no texture shows stays where the shift put it.
constexpr double kDamping = 1e-3;
constexpr double kMaxStepRad = 0.3;  // a longer one leads away from a shift that correlates
// Huber's bound, grey levels: exposure and parallax leave residuals of that order at this
// resolution.
constexpr float kHuberGreys = 15.0F;

// The rotation that carries the ray of j's image centre to where the shift puts it.
Eigen::Quaterniond RotationOfShift(const PinholeCamera& camera, const ImageShift& shift) {
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

// Numbers of a row of j's pixels turned into camera i, one array per quantity so that loops are
// vectorised.
class TurnedRow {
 public:
  explicit TurnedRow(const PinholeCamera& camera)
      : camera_(camera), width_(static_cast<std::size_t>(camera.width)), pixel_(width_) {
    for (std::vector<float>& numbers : numbers_) numbers.resize(width_);
  }

  // Where the pixels of row v lie in image i; pixel -1 outside it.
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
    std::int32_t* const pixel = pixel_.data();
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
      pixel[u] = inside ? nearest_v * width + nearest_u : -1;
    }
  }

  // Residuals to first order from the nearest pixel's centre, their weights and Jacobians.
  void Compare(const UnfilledVector<IntensityPixel>& i, const float* row_of_j) {
    float *const value = (*this)[kResidual], *const du = (*this)[kDu], *const dv = (*this)[kDv];
    for (std::size_t u = 1; u + 1 < width_; ++u) {
      const IntensityPixel& to = i[static_cast<std::size_t>(std::max(0, pixel_[u]))];
      value[u] = to.value;
      du[u] = to.du;
      dv[u] = to.dv;
    }
    const float fx = static_cast<float>(camera_.fx), fy = static_cast<float>(camera_.fy);
    float *const rx = (*this)[kRayX], *const ry = (*this)[kRayY], *const rz = (*this)[kRayZ];
    float *const off_u = (*this)[kOffsetU], *const off_v = (*this)[kOffsetV];
    float* const weight = (*this)[kWeight];
    const std::int32_t* const pixel = pixel_.data();
#pragma GCC ivdep
    for (std::size_t u = 1; u < width_ - 1; ++u) {
      const float residual = value[u] + du[u] * off_u[u] + dv[u] * off_v[u] - row_of_j[u];
      const float x = rx[u], y = ry[u], z = rz[u];
      const float gx = du[u] * fx / z, gy = dv[u] * fy / z;
      const float gz = -(gx * x + gy * y) / z;
      const bool counts = pixel[u] >= 0;
      weight[u] = kHuberGreys / std::max(kHuberGreys, std::abs(residual));
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
      sum.count += pixel_[u] >= 0 ? 1 : 0;
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
  std::vector<std::int32_t> pixel_;
  std::array<std::vector<float>, kNumQuantities> numbers_;
};

RotationSystem BuildRotationSystem(const UnfilledVector<IntensityPixel>& i,
                                   const PyramidLevel& j,
                                   const Eigen::Quaterniond& i_from_j,
                                   TurnedRow& row) {
  const PinholeCamera& camera = j.camera;
  RotationSystem system;
  for (int v = 1; v + 1 < camera.height; ++v) {
    row.Turn(i_from_j, v);
    row.Compare(i, j.intensity.row(v));
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
  if (coarse_i.intensity.empty() || coarse_i.intensity.size() != coarse_j.intensity.size())
    return std::nullopt;
  const ImageShift shift = BestShift(coarse_i, coarse_j);
  if (shift.correlation < kMinShiftCorrelation) return std::nullopt;
  Eigen::Quaterniond best = RotationOfShift(coarse_i.camera, shift);
  Eigen::Quaterniond rotation = best;
  double best_error = -1;
  const UnfilledVector<IntensityPixel> pixels = WithDerivatives(coarse_i.intensity);
  TurnedRow row(coarse_i.camera);
  for (int n = 0; n < kMaxRefinements; ++n) {
    const RotationSystem system = BuildRotationSystem(pixels, coarse_j, rotation, row);
    if (system.count < kMinPixels) break;
    const double error = system.sum_squared / system.count;
    if (best_error >= 0 && error >= best_error) break;
    best = rotation;
    best_error = error;
    const Eigen::Matrix3d damped =
        system.hessian + kDamping * system.hessian.trace() * Eigen::Matrix3d::Identity();
    const Eigen::Vector3d step = -damped.ldlt().solve(system.gradient);
    if (!step.allFinite() || step.norm() > kMaxStepRad) break;
    rotation = (RotationFromVector(step) * rotation).normalized();
  }
  return best;
}

}  // namespace deepslam::alignment
