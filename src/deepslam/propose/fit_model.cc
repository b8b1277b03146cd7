#include "deepslam/propose/fit_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <Eigen/Cholesky>

#include "deepslam/core/wide_vectors.h"
#include "deepslam/geometry/normal_equations.h"
#include "deepslam/geometry/point_columns.h"
#include "deepslam/propose/depth_evidence.h"

namespace deepslam::propose {
namespace {

// Unknowns: x, y, bottom z, yaw, log size along x, y, z.
using Vector7 = SevenEquations::Vector;
using Matrix7 = SevenEquations::Matrix;

// The placement's maps in float, for inner loops.
struct Frame {
  float cosine, sine;  // of the turn, level from box
  Triple metres;       // per object unit, along the box's axes
  Triple center;       // of the box in the level frame

  Frame(const CoarseShape& shape, const Placement& placement)
      : cosine(static_cast<float>(std::cos(placement.yaw_rad))),
        sine(static_cast<float>(std::sin(placement.yaw_rad))) {
    const Eigen::Vector3f size_m = placement.size_m.cast<float>();
    metres = {size_m.x() / shape.extent().x(),
              size_m.y() / shape.extent().y(),
              size_m.z() / shape.extent().z()};
    center = {static_cast<float>(placement.center_m.x()),
              static_cast<float>(placement.center_m.y()),
              static_cast<float>(placement.bottom_m + 0.5 * placement.size_m.z())};
  }
  [[nodiscard]] Triple ToBox(const Triple& p_level) const {
    const Triple q = p_level - center;
    return {cosine * q.x + sine * q.y, -sine * q.x + cosine * q.y, q.z};
  }
  [[nodiscard]] Triple ToLevel(const Triple& p_object) const {
    const Triple q = {p_object.x * metres.x, p_object.y * metres.y, p_object.z * metres.z};
    return {cosine * q.x + -sine * q.y + center.x,
            sine * q.x + cosine * q.y + center.y,
            q.z + center.z};
  }
};

// Some points side by side; lanes after the last repeat it.
struct PointLanes {
  std::size_t size = 0;
  VectorColumns points;

  // At most so many, from the first-th on.
  void Load(std::span<const Eigen::Vector3f> all, std::size_t first, std::size_t most) {
    size = std::min(most, all.size() - first);
    for (std::size_t k = 0; k < whole(); ++k) {
      const Eigen::Vector3f& p = all[first + std::min(k, size - 1)];
      points.Set(k, p.x(), p.y(), p.z());
    }
  }
  [[nodiscard]] std::size_t whole() const { return WholeLanes(size); }
};

// Distances in metres and their gradients in the box frame. The field is that of the unit model: to
// first order the distance after an uneven stretch is the unit distance over the length of its
// stretched gradient.
struct MetricColumns {
  VectorColumns q_box;
  PointColumn distance_m;
  VectorColumns direction;

  void Measure(const CoarseShape& shape, const Frame& frame, const PointLanes& batch) {
    const std::size_t whole = batch.whole();
    const Triple metres = frame.metres;
    VectorColumns unit;
#pragma GCC ivdep
    for (std::size_t k = 0; k < whole; ++k) {
      const Triple q = frame.ToBox(TripleAt(batch.points, k));
      q_box.Set(k, q.x, q.y, q.z);
      unit.Set(k, q.x / metres.x, q.y / metres.y, q.z / metres.z);
    }
    shape::FieldSampleColumns samples;
    shape.At(unit, whole, samples);
#pragma GCC ivdep
    for (std::size_t k = 0; k < whole; ++k) {
      const Triple slope = {samples.gradient.x[k] / metres.x,
                            samples.gradient.y[k] / metres.y,
                            samples.gradient.z[k] / metres.z};
      const float length = std::sqrt(Dot(slope, slope));
      const float steepness = length > 1e-6F ? length : 1e-6F;
      distance_m[k] = samples.distance[k] / steepness;
      direction.Set(k, slope.x / steepness, slope.y / steepness, slope.z / steepness);
    }
  }
};

double HarmonicMean(double a, double b) { return 2.0 * a * b / std::max(a + b, 1e-9); }

void AddPrior(double deviation, double sigma, int n, Matrix7& h, Vector7& g) {
  h(n, n) += 1.0 / (sigma * sigma);
  g[n] += deviation / (sigma * sigma);
}

// How many views call a point free, and how many surface.
struct EvidenceCounts {
  std::array<std::int32_t, kPointBatch> free, surface;

  void Count(std::span<const shape::DepthView> views,
             const VectorColumns& points_level,
             std::size_t size,
             float slack_m) {
    std::fill_n(free.begin(), size, 0);
    std::fill_n(surface.begin(), size, 0);
    EvidenceColumns evidence;
    for (const shape::DepthView& view : views) {
      evidence.Take(view, points_level, size, slack_m);
#pragma GCC ivdep
      for (std::size_t n = 0; n < size; ++n) {
        free[n] += evidence.is_free[n];
        surface[n] += evidence.is_surface[n];
      }
    }
  }
};

// Points side by side of which each says that its distance shall vanish.
struct ResidualRows {
  std::array<SevenEquations::Row, kPointBatch> rows;
  std::array<double, kPointBatch> weights;

  // Unit: information of a point, 1 / m^2.
  void Linearise(const MetricColumns& at,
                 std::size_t size,
                 const Frame& frame,
                 double height_m,
                 double point_sigma_m,
                 double unit) {
    const auto c = static_cast<double>(frame.cosine);
    const auto s = static_cast<double>(frame.sine);
#pragma GCC ivdep
    for (std::size_t k = 0; k < size; ++k) {
      const auto x = static_cast<double>(at.direction.x[k]);
      const auto y = static_cast<double>(at.direction.y[k]);
      const auto z = static_cast<double>(at.direction.z[k]);
      const auto q_x = static_cast<double>(at.q_box.x[k]);
      const auto q_y = static_cast<double>(at.q_box.y[k]);
      const auto q_z = static_cast<double>(at.q_box.z[k]);
      const auto distance_m = static_cast<double>(at.distance_m[k]);
      rows[k] = {-(c * x + -s * y),
                 -(s * x + c * y),
                 -z,
                 x * q_y - y * q_x,
                 -x * q_x,
                 -y * q_y,
                 // Growing in height moves the box's centre up as well, since its bottom stays.
                 -z * (q_z + 0.5 * height_m),
                 distance_m};
      const double scaled = distance_m / (2.0 * point_sigma_m);
      const double robust = 1.0 / (1.0 + scaled * scaled);  // Cauchy
      weights[k] = unit * robust * robust / (point_sigma_m * point_sigma_m);
    }
  }
};

}  // namespace

DEEPSLAM_WIDE_VECTORS Placement RefinePlacement(const CoarseShape& shape,
                                                const Placement& start,
                                                const Eigen::Vector3d& prior_size_m,
                                                std::span<const Eigen::Vector3f> points_level,
                                                const FitTerms& terms) {
  constexpr int kIterations = 6;        // of Gauss-Newton, each of 0.2 rad and 20 % of size at most
  constexpr double kPoseSigma_m = 0.3;  // keeps directions without evidence still
  // 17 degrees: starts are up to 15 degrees off (kNumYaws of place_shape.cc).
  constexpr double kYawSigma_rad = 0.3;
  // Neighbouring points share their errors (calibration, segment's rim): they count as this many
  // independent ones.
  constexpr double kIndependent = 60;
  Placement now = start;
  const double share = points_level.empty()
                           ? 0.0
                           : std::min(1.0, kIndependent / static_cast<double>(points_level.size()));
  PointLanes batch;
  MetricColumns at;
  ResidualRows residuals;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const Frame frame(shape, now);
    SevenEquations equations;
    for (std::size_t n = 0; n < points_level.size(); n += kPointBatch) {
      batch.Load(points_level, n, kPointBatch);
      at.Measure(shape, frame, batch);
      residuals.Linearise(at, batch.size, frame, now.size_m.z(), terms.point_sigma_m, share);
      equations.Add(residuals.rows.data(), residuals.weights.data(), batch.size);
    }
    Matrix7 h = equations.Hessian();
    Vector7 g = equations.Gradient();
    for (int n = 0; n < 2; ++n)
      AddPrior(now.center_m[n] - start.center_m[n], kPoseSigma_m, n, h, g);
    AddPrior(now.bottom_m - start.bottom_m, terms.bottom_sigma_m, 2, h, g);
    AddPrior(now.yaw_rad - start.yaw_rad, kYawSigma_rad, 3, h, g);
    for (int n = 0; n < 3; ++n) {
      AddPrior(std::log(now.size_m[n] / prior_size_m[n]), terms.catalogue_sigma, 4 + n, h, g);
    }
    const Vector7 step = h.ldlt().solve(-g);
    if (!step.allFinite()) return now;
    now.center_m += step.head<2>();
    now.bottom_m += step[2];
    now.yaw_rad += std::clamp(step[3], -0.2, 0.2);
    now.size_m.array() *= step.tail<3>().array().max(-0.2).min(0.2).exp();
  }
  return now;
}

DEEPSLAM_WIDE_VECTORS double ScorePlacement(const CoarseShape& shape,
                                            const Placement& placement,
                                            std::span<const Eigen::Vector3f> points_level,
                                            std::span<const shape::DepthView> views,
                                            double tolerance_m,
                                            double to_beat) {
  constexpr std::size_t kBetweenLooks = 32;  // points between looks at what can still be reached
  if (points_level.empty() || shape.empty()) return 0;
  const Frame frame(shape, placement);
  PointLanes batch;
  MetricColumns at;
  std::array<double, kPointBatch> agreements;
  double on_surface = 0;
  for (std::size_t n = 0; n < points_level.size(); n += kPointBatch) {
    batch.Load(points_level, n, kPointBatch);
    at.Measure(shape, frame, batch);
    for (std::size_t k = 0; k < batch.size; ++k) {
      const double scaled = static_cast<double>(at.distance_m[k]) / tolerance_m;
      agreements[k] = 1.0 / (1.0 + scaled * scaled);
    }
    for (std::size_t k = 0; k < batch.size; ++k) on_surface += agreements[k];
  }
  const double point_share = on_surface / static_cast<double>(points_level.size());
  double confirmed = 0;
  double known = 0;
  EvidenceCounts counts;
  for (std::size_t n = 0; n < shape.surface().size(); n += kBetweenLooks) {
    // If all that is left were confirmed.
    const auto left = static_cast<double>(shape.surface().size() - n);
    const double at_most = HarmonicMean(point_share, (confirmed + left) / (known + left));
    if (at_most <= to_beat) return at_most;
    batch.Load(shape.surface(), n, kBetweenLooks);
    const std::size_t whole = batch.whole();
#pragma GCC ivdep
    for (std::size_t k = 0; k < whole; ++k) {
      const Triple p_level = frame.ToLevel(TripleAt(batch.points, k));
      batch.points.Set(k, p_level.x, p_level.y, p_level.z);
    }
    counts.Count(views, batch.points, whole, static_cast<float>(0.5 * tolerance_m));
    for (std::size_t k = 0; k < batch.size; ++k) {
      const int free = counts.free[k];
      const int seen = counts.surface[k];
      if (free + seen == 0) continue;
      known += 1;
      confirmed += static_cast<double>(seen) / (free + seen);
    }
  }
  if (known == 0) return 0;
  return HarmonicMean(point_share, confirmed / known);
}

}  // namespace deepslam::propose
