#include "deepslam/odometry/rotation_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Cholesky>

namespace deepslam::odometry {
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

// Normalised cross-correlation of I_j(u, v) with I_i(u + shift).
double Correlation(const PyramidLevel& i, const PyramidLevel& j, int shift_u, int shift_v) {
  const int width = i.camera.width, height = i.camera.height;
  float n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
  for (int v = std::max(0, -shift_v); v < std::min(height, height - shift_v); ++v) {
    const IntensityTexel* source = j.intensity.data() + static_cast<std::ptrdiff_t>(v) * width;
    const IntensityTexel* target =
        i.intensity.data() + static_cast<std::ptrdiff_t>(v + shift_v) * width + shift_u;
    for (int u = std::max(0, -shift_u); u < std::min(width, width - shift_u); ++u) {
      // Centred on mid-grey, so that single precision does for the sums.
      const float x = source[u].value - 128.0F, y = target[u].value - 128.0F;
      n += 1, a += x, b += y, aa += x * x, bb += y * y, ab += x * y;
    }
  }
  if (n < 1) return -1;
  const double count = static_cast<double>(n);
  const double var_a =
      static_cast<double>(aa) / count - std::pow(static_cast<double>(a) / count, 2);
  const double var_b =
      static_cast<double>(bb) / count - std::pow(static_cast<double>(b) / count, 2);
  const double covariance = static_cast<double>(ab) / count -
                            static_cast<double>(a) / count * (static_cast<double>(b) / count);
  // Below one grey level of spread there is nothing to correlate.
  return var_a > 1 && var_b > 1 ? covariance / std::sqrt(var_a * var_b) : -1;
}

Shift BestShift(const PyramidLevel& i, const PyramidLevel& j) {
  const int max_u = static_cast<int>(kMaxShiftShare * i.camera.width);
  const int max_v = static_cast<int>(kMaxShiftShare * i.camera.height);
  Shift best;
  for (int v = -max_v; v <= max_v; ++v) {
    for (int u = -max_u; u <= max_u; ++u) {
      // Small overlaps correlate by chance: shrink them.
      const double overlap = (1 - std::abs(u) / static_cast<double>(i.camera.width)) *
                             (1 - std::abs(v) / static_cast<double>(i.camera.height));
      const double correlation = Correlation(i, j, u, v) * std::sqrt(overlap);
      if (correlation > best.correlation) best = {u, v, correlation};
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
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  double sum_squared = 0;
  int count = 0;
};

RotationSystem BuildRotationSystem(const PyramidLevel& i,
                                   const PyramidLevel& j,
                                   const Eigen::Quaterniond& i_from_j) {
  const PinholeCamera& camera = i.camera;
  RotationSystem system;
  for (int v = 1; v + 1 < camera.height; ++v) {
    for (int u = 1; u + 1 < camera.width; ++u) {
      const Eigen::Vector3d ray = i_from_j * camera.Ray(u, v);
      const auto pixel = camera.Project(ray);
      if (!pixel || pixel->x() < 1 || pixel->y() < 1 || pixel->x() >= camera.width - 2 ||
          pixel->y() >= camera.height - 2) {
        continue;
      }
      const std::size_t width = static_cast<std::size_t>(camera.width);
      const std::size_t target = static_cast<std::size_t>(pixel->y() + 0.5) * width +
                                 static_cast<std::size_t>(pixel->x() + 0.5);
      const IntensityTexel& to = i.intensity[target];
      const IntensityTexel& from =
          j.intensity[static_cast<std::size_t>(v) * width + static_cast<std::size_t>(u)];
      // First order from the nearest texel's centre.
      const double offset_u = pixel->x() - std::floor(pixel->x() + 0.5);
      const double offset_v = pixel->y() - std::floor(pixel->y() + 0.5);
      const double du = static_cast<double>(to.du), dv = static_cast<double>(to.dv);
      const double residual = static_cast<double>(to.value) + du * offset_u + dv * offset_v -
                              static_cast<double>(from.value);
      const double gx = du * camera.fx / ray.z(), gy = dv * camera.fy / ray.z();
      const Eigen::Vector3d direction(gx, gy, -(gx * ray.x() + gy * ray.y()) / ray.z());
      const Eigen::Vector3d jacobian = ray.cross(direction);
      // Huber at 15 grey levels: exposure and parallax leave residuals of that order at this
      // resolution.
      const double weight = std::abs(residual) > 15 ? 15 / std::abs(residual) : 1.0;
      system.hessian += weight * jacobian * jacobian.transpose();
      system.gradient += weight * residual * jacobian;
      system.sum_squared += weight * residual * residual;
      ++system.count;
    }
  }
  return system;
}

}  // namespace

std::optional<Eigen::Quaterniond> SearchRotation(const FramePyramid& i, const FramePyramid& j) {
  if (i.empty() || j.empty() || i.levels.size() != j.levels.size()) return std::nullopt;
  const PyramidLevel& coarse_i = i.levels.back();
  const PyramidLevel& coarse_j = j.levels.back();
  if (coarse_i.intensity.empty() || coarse_i.intensity.size() != coarse_j.intensity.size())
    return std::nullopt;
  const Shift shift = BestShift(coarse_i, coarse_j);
  if (shift.correlation < kMinCorrelation) return std::nullopt;
  Eigen::Quaterniond best = RotationOfShift(coarse_i.camera, shift);
  Eigen::Quaterniond rotation = best;
  double best_error = -1;
  for (int n = 0; n < kMaxRefinements; ++n) {
    const RotationSystem system = BuildRotationSystem(coarse_i, coarse_j, rotation);
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

}  // namespace deepslam::odometry
