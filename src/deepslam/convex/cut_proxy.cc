#include "deepslam/convex/cut_proxy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include <Eigen/Eigenvalues>

namespace deepslam::convex {
namespace {

constexpr std::size_t kCutPlaces = 64;  // along a direction: a grid has hardly more cells

struct Moments {
  double count = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();

  void Add(const Eigen::Vector3d& p) {
    count += 1;
    sum += p;
    products += p * p.transpose();
  }
  void Add(const Moments& other, double sign) {
    count += sign * other.count;
    sum += sign * other.sum;
    products += sign * other.products;
  }
  [[nodiscard]] Eigen::Matrix3d Covariance() const {
    const Eigen::Vector3d mean = sum / count;
    return products / count - mean * mean.transpose();
  }
  // In cells, up to a factor: a box's volume goes with the root of the determinant.
  [[nodiscard]] double BoxVolume(double cell_m) const {
    // A cell is no point, and has a box of its own.
    const Eigen::Matrix3d spread =
        Covariance() / (cell_m * cell_m) + Eigen::Matrix3d::Identity() / 12;
    return std::sqrt(std::max(0.0, spread.determinant()));
  }
};

std::vector<Eigen::Vector3d> Directions(const Moments& all) {
  const double half = std::sqrt(0.5);
  std::vector<Eigen::Vector3d> directions = {{1, 0, 0},
                                             {0, 1, 0},
                                             {0, 0, 1},
                                             {half, half, 0},
                                             {half, -half, 0},
                                             {half, 0, half},
                                             {half, 0, -half},
                                             {0, half, half},
                                             {0, half, -half}};
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(all.Covariance());
  for (int axis = 0; axis < 3; ++axis) directions.emplace_back(solver.eigenvectors().col(axis));
  return directions;
}

struct Cut {
  double volume = std::numeric_limits<double>::infinity();
  CutPlane plane;
};

Cut BestAlong(const Eigen::Vector3d& direction,
              std::span<const Eigen::Vector3f> centres,
              const Moments& all,
              float cell_m) {
  Cut best;
  const Eigen::Vector3f normal = direction.cast<float>();
  float low = std::numeric_limits<float>::infinity();
  float high = -low;
  for (const Eigen::Vector3f& p : centres) {
    low = std::min(low, normal.dot(p));
    high = std::max(high, normal.dot(p));
  }
  if (!(high - low > 0.5F * cell_m)) return best;
  const float step = std::max((high - low) / static_cast<float>(kCutPlaces), cell_m);
  std::array<Moments, kCutPlaces + 1> bins;
  const Eigen::Vector3d origin = centres.front().cast<double>();
  for (const Eigen::Vector3f& p : centres) {
    const auto bin = static_cast<std::size_t>((normal.dot(p) - low) / step);
    bins[std::min(bin, kCutPlaces)].Add(p.cast<double>() - origin);
  }
  Moments below;
  for (std::size_t n = 0; n < kCutPlaces; ++n) {
    below.Add(bins[n], 1);
    Moments above = all;
    above.Add(below, -1);
    if (below.count < 1 || above.count < 1) continue;
    const double volume = below.BoxVolume(cell_m) + above.BoxVolume(cell_m);
    if (volume >= best.volume) continue;
    best.volume = volume;
    best.plane = {normal, low + static_cast<float>(n + 1) * step};
  }
  return best;
}

}  // namespace

std::vector<CutPlane> BestCuts(std::span<const Eigen::Vector3f> centres,
                               float cell_m,
                               std::size_t max_cuts) {
  if (centres.size() < 2) return {};
  Moments all;
  for (const Eigen::Vector3f& p : centres) all.Add((p - centres.front()).cast<double>());
  std::vector<Cut> cuts;
  for (const Eigen::Vector3d& direction : Directions(all)) {
    const Cut cut = BestAlong(direction, centres, all, cell_m);
    if (std::isfinite(cut.volume)) cuts.push_back(cut);
  }
  std::stable_sort(
      cuts.begin(), cuts.end(), [](const Cut& a, const Cut& b) { return a.volume < b.volume; });
  cuts.resize(std::min(cuts.size(), max_cuts));
  std::vector<CutPlane> planes;
  for (const Cut& cut : cuts) planes.push_back(cut.plane);
  return planes;
}

}  // namespace deepslam::convex
