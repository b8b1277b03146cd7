#include "deepslam/synth/sensor_faults.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "deepslam/core/parallel.h"

namespace deepslam::synth {
namespace {

// Standard deviation of the place a depth value really comes from (Nguyen et al. 2012: 0.8 px; much
// of that is the matching window, which the steps at edges show already).
constexpr double kLateralNoisePx = 0.5;
// Share of light that comes back from a face seen under a cosine; below, the pattern is lost.
constexpr float kMinCosine = 0.12f;
constexpr float kSureCosine = 0.25f;
constexpr double kColourNoise = 0.010;  // of full scale
constexpr double kVignetting = 0.18;    // darkening at the corners

std::uint64_t RowItem(std::uint64_t item, std::size_t row) { return item * 65'536 + row; }

// A pixel is in the projector's shadow when another one on its row lies before it as the projector
// sees it: seen from there, columns are u - f b / z, and a nearer surface to the projector's side
// covers what is behind.
std::vector<std::uint8_t> ShadowOfRow(const DepthImage& depth_m,
                                      int v,
                                      double focal_baseline_px_m) {
  std::vector<std::uint8_t> shadow(static_cast<std::size_t>(depth_m.width()), 0);
  double reach = std::numeric_limits<double>::infinity();
  for (int u = depth_m.width() - 1; u >= 0; --u) {
    const double d = static_cast<double>(depth_m(u, v));
    if (d <= 0) continue;
    const double column = u + focal_baseline_px_m / d;
    // Half a pixel of slack: neighbours on one slanted surface may swap by rounding.
    if (column > reach + 0.5) shadow[static_cast<std::size_t>(u)] = 1;
    reach = std::min(reach, column);
  }
  return shadow;
}

float Cosine(const render::RayHit& hit,
             const PinholeCamera& camera,
             const Eigen::Matrix3d& rotation,
             int u,
             int v) {
  const Eigen::Vector3d ray_world = rotation * camera.Ray(u, v).normalized();
  return static_cast<float>(-ray_world.dot(hit.normal_world.cast<double>()));
}

double Quantised(double depth_m, double focal_baseline_px_m) {
  const double disparity =
      std::round(focal_baseline_px_m / depth_m / kDisparityStepPx) * kDisparityStepPx;
  return disparity > 0 ? focal_baseline_px_m / disparity : 0.0;
}

// Gaussian of 0.6 px, which a cheap lens and the colour filter leave.
Image<Eigen::Vector3f> Blurred(const Image<Eigen::Vector3f>& from) {
  constexpr std::array<float, 3> kWeights = {0.166f, 0.668f, 0.166f};
  const auto pass = [&](const Image<Eigen::Vector3f>& in, int du, int dv) {
    Image<Eigen::Vector3f> out(in.width(), in.height(), Eigen::Vector3f::Zero());
    ParallelFor(static_cast<std::size_t>(in.height()), [&](std::size_t row) {
      const int v = static_cast<int>(row);
      for (int u = 0; u < in.width(); ++u) {
        for (int k = -1; k <= 1; ++k) {
          const int a = std::clamp(u + k * du, 0, in.width() - 1);
          const int b = std::clamp(v + k * dv, 0, in.height() - 1);
          out(u, v) += kWeights[static_cast<std::size_t>(k + 1)] * in(a, b);
        }
      }
    });
    return out;
  };
  return pass(pass(from, 1, 0), 0, 1);
}

std::uint8_t Display(double linear) {
  const double c = std::clamp(linear, 0.0, 1.0);
  const double s = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * s));
}

}  // namespace

double AxialNoise(double depth_m) {
  const double beyond = depth_m - 0.4;
  return 0.0012 + 0.0019 * beyond * beyond;
}

DepthImage ApplyDepthFaults(const render::RenderedView& truth,
                            const PinholeCamera& camera,
                            const Pose3& world_from_camera,
                            const SensorFaults& faults,
                            std::uint64_t seed,
                            std::uint64_t random_item) {
  const Eigen::Matrix3d rotation = world_from_camera.rotation.toRotationMatrix();
  const double focal_baseline = camera.fx * kBaselineM;
  DepthImage seen(camera.width, camera.height, 0.0f);
  ParallelFor(static_cast<std::size_t>(camera.height), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    Random random(seed, "depth", RowItem(random_item, row));
    const std::vector<std::uint8_t> shadow = ShadowOfRow(truth.depth_m, v, focal_baseline);
    for (int u = 0; u < camera.width; ++u) {
      int from_u = u;
      int from_v = v;
      if (faults.depth_noise) {
        from_u = std::clamp(static_cast<int>(std::lround(u + kLateralNoisePx * random.Normal())),
                            0,
                            camera.width - 1);
        from_v = std::clamp(static_cast<int>(std::lround(v + kLateralNoisePx * random.Normal())),
                            0,
                            camera.height - 1);
      }
      double depth = static_cast<double>(truth.depth_m(from_u, from_v));
      if (depth <= 0) continue;
      if (faults.depth_holes) {
        const float cosine = Cosine(truth.hits(from_u, from_v), camera, rotation, from_u, from_v);
        const double lost =
            static_cast<double>((kSureCosine - cosine) / (kSureCosine - kMinCosine));
        if (random.Uniform() < lost || shadow[static_cast<std::size_t>(from_u)] != 0) continue;
        if (depth < kMinRangeM || depth > kMaxRangeM) continue;
      }
      if (faults.depth_noise) {
        depth =
            Quantised(std::max(0.05, depth + AxialNoise(depth) * random.Normal()), focal_baseline);
      }
      seen(u, v) = static_cast<float>(depth);
    }
  });
  return seen;
}

ColourImage DevelopColour(const Image<Eigen::Vector3f>& radiance,
                          const SensorFaults& faults,
                          std::uint64_t seed,
                          std::uint64_t random_item) {
  const int width = radiance.width();
  const int height = radiance.height();
  const Image<Eigen::Vector3f> picture = faults.colour_noise ? Blurred(radiance) : radiance;
  ColourImage colour(width, height);
  ParallelFor(static_cast<std::size_t>(height), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    Random random(seed, "colour", RowItem(random_item, row));
    for (int u = 0; u < width; ++u) {
      Eigen::Vector3d c = picture(u, v).cast<double>();
      if (faults.colour_noise) {
        const double x = 2.0 * u / width - 1;
        const double y = 2.0 * v / height - 1;
        c *= 1 - kVignetting * 0.5 * (x * x + y * y);
        // Photon noise grows with the root of the light.
        for (int k = 0; k < 3; ++k)
          c[k] += kColourNoise * std::sqrt(std::max(c[k], 0.02)) * random.Normal();
      }
      colour(u, v) = {Display(c.x()), Display(c.y()), Display(c.z())};
    }
  });
  return colour;
}

}  // namespace deepslam::synth
