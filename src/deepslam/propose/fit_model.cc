#include "deepslam/propose/fit_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <Eigen/Cholesky>

#include "deepslam/core/wide_vectors.h"
#include "deepslam/geometry/normal_equations.h"
#include "deepslam/propose/depth_evidence.h"

namespace deepslam::propose {
namespace {

// Unknowns: x, y, bottom z, yaw, log size along x, y, z.
using Vector7 = SevenEquations::Vector;
using Matrix7 = SevenEquations::Matrix;

// The placement's maps in float, for inner loops.
struct Frame {
  Eigen::Matrix2f turn;    // level from box
  Eigen::Vector3f metres;  // per object unit, along the box's axes
  Eigen::Vector3f center;  // of the box in the level frame

  Frame(const CoarseShape& shape, const Placement& placement) {
    const auto c = static_cast<float>(std::cos(placement.yaw_rad));
    const auto s = static_cast<float>(std::sin(placement.yaw_rad));
    turn << c, -s, s, c;
    metres = placement.size_m.cast<float>().cwiseQuotient(shape.extent());
    center << placement.center_m.cast<float>(),
        static_cast<float>(placement.bottom_m + 0.5 * placement.size_m.z());
  }
  [[nodiscard]] Eigen::Vector3f ToBox(const Eigen::Vector3f& p_level) const {
    Eigen::Vector3f q = p_level - center;
    q.head<2>() = turn.transpose() * q.head<2>();
    return q;
  }
  [[nodiscard]] Eigen::Vector3f ToLevel(const Eigen::Vector3f& p_object) const {
    Eigen::Vector3f q = p_object.cwiseProduct(metres);
    q.head<2>() = turn * q.head<2>();
    return q + center;
  }
};

// Distance in metres and its gradient in the box frame. The field is that of the unit model: to
// first order the distance after an uneven stretch is the unit distance over the length of its
// stretched gradient.
struct MetricSample {
  double distance_m;
  Eigen::Vector3d direction;
};

MetricSample MetricAt(const CoarseShape& shape, const Frame& frame, const Eigen::Vector3f& q_box) {
  const CoarseShape::Sample sample = shape.At(q_box.cwiseQuotient(frame.metres));
  const Eigen::Vector3f slope = sample.gradient.cwiseQuotient(frame.metres);
  const float steepness = std::max(slope.norm(), 1e-6F);
  return {static_cast<double>(sample.distance / steepness), (slope / steepness).cast<double>()};
}

double HarmonicMean(double a, double b) { return 2.0 * a * b / std::max(a + b, 1e-9); }

void AddPrior(double deviation, double sigma, int n, Matrix7& h, Vector7& g) {
  h(n, n) += 1.0 / (sigma * sigma);
  g[n] += deviation / (sigma * sigma);
}

}  // namespace

DEEPSLAM_WIDE_VECTORS Placement RefinePlacement(const CoarseShape& shape,
                                                const Placement& start,
                                                const Eigen::Vector3d& prior_size_m,
                                                std::span<const Eigen::Vector3f> points_level,
                                                const FitTerms& terms) {
  constexpr int kIterations = 6;
  constexpr double kPoseSigma_m = 0.3;  // keeps directions without evidence still
  constexpr double kYawSigma_rad = 0.3;
  // Neighbouring points share their errors (calibration, segment's rim): they count as this many
  // independent ones.
  constexpr double kIndependent = 60;
  Placement now = start;
  const double share = points_level.empty()
                           ? 0.0
                           : std::min(1.0, kIndependent / static_cast<double>(points_level.size()));
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const Frame frame(shape, now);
    const Eigen::Matrix2d turn = frame.turn.cast<double>();
    SevenEquations equations;
    for (const Eigen::Vector3f& p_level : points_level) {
      const Eigen::Vector3f q_box = frame.ToBox(p_level);
      const MetricSample at = MetricAt(shape, frame, q_box);
      const Eigen::Vector3d q = q_box.cast<double>();
      const Eigen::Vector2d level = turn * at.direction.head<2>();
      const std::array<double, 7> jacobian = {
          -level.x(),
          -level.y(),
          -at.direction.z(),
          at.direction.x() * q.y() - at.direction.y() * q.x(),
          -at.direction.x() * q.x(),
          -at.direction.y() * q.y(),
          // Growing in height moves the box's centre up as well, since its bottom stays.
          -at.direction.z() * (q.z() + 0.5 * now.size_m.z())};
      const double scaled = at.distance_m / (2.0 * terms.point_sigma_m);
      const double robust = 1.0 / (1.0 + scaled * scaled);  // Cauchy
      const double weight = share * robust * robust / (terms.point_sigma_m * terms.point_sigma_m);
      equations.Add(jacobian, at.distance_m, weight);
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
  if (points_level.empty() || shape.empty()) return 0;
  const Frame frame(shape, placement);
  double on_surface = 0;
  for (const Eigen::Vector3f& p_level : points_level) {
    const double scaled = MetricAt(shape, frame, frame.ToBox(p_level)).distance_m / tolerance_m;
    on_surface += 1.0 / (1.0 + scaled * scaled);
  }
  const double point_share = on_surface / static_cast<double>(points_level.size());
  double confirmed = 0;
  double known = 0;
  double left = static_cast<double>(shape.surface().size());
  for (const Eigen::Vector3f& p_object : shape.surface()) {
    // If all that is left were confirmed.
    const double at_most = HarmonicMean(point_share, (confirmed + left) / (known + left));
    if (at_most <= to_beat) return at_most;
    left -= 1;
    const Eigen::Vector3f p_level = frame.ToLevel(p_object);
    int free = 0;
    int seen = 0;
    for (const shape::DepthView& view : views) {
      const Evidence evidence =
          EvidenceAt(view, p_level, static_cast<float>(0.5 * tolerance_m)).evidence;
      free += evidence == Evidence::kFree ? 1 : 0;
      seen += evidence == Evidence::kSurface ? 1 : 0;
    }
    if (free + seen == 0) continue;
    known += 1;
    confirmed += static_cast<double>(seen) / (free + seen);
  }
  if (known == 0) return 0;
  return HarmonicMean(point_share, confirmed / known);
}

}  // namespace deepslam::propose
