#include "deepslam/segment/level_top.h"

#include <algorithm>
#include <cmath>

#include "deepslam/scene/ground.h"
#include "deepslam/segment/connect.h"

namespace deepslam::segment {
namespace {

// Tops of tables and desks, from coffee tables to bars; lower ones are seats and shelves.
constexpr double kLowest_m = 0.30;
constexpr double kHighest_m = 1.30;
constexpr double kBin_m = 0.02;
constexpr double kThickness_m = 0.025;     // pixels this near to the top's height are the top ...
constexpr double kThicknessPerM2 = 0.005;  // ... plus this times the squared depth
constexpr double kGap_m = 0.30;    // parts of a top hidden from each other by what stands before it
constexpr double kEdge_m = 0.04;   // legs may stand this far out of the visible top
constexpr double kReach_m = 0.12;  // what carries a top is seen up to this close below it
constexpr double kMostAbove = 0.05;   // share of a piece's pixels that may rise above the top
constexpr double kLeastReach = 0.01;  // share of a piece's pixels that must come close to it
constexpr int kMinTop_px = 150;

double ThicknessAt(double depth_m) { return kThickness_m + kThicknessPerM2 * depth_m * depth_m; }

// Height with the largest level area in the region; pixels weigh what they cover in space.
std::optional<double> DominantHeight(const ImagePieces& pieces, const Region& region) {
  constexpr int kNumBins = static_cast<int>((kHighest_m - kLowest_m) / kBin_m) + 1;
  std::vector<double> area(kNumBins, 0.0);
  int count = 0;
  region.ForEach([&](int u, int v) {
    if (pieces.horizontal(u, v) == 0) return;
    const double height_m = pieces.height_m(u, v);
    if (height_m < kLowest_m || height_m >= kHighest_m) return;
    const double z = pieces.points_camera(u, v).z();
    area[static_cast<std::size_t>((height_m - kLowest_m) / kBin_m)] += z * z;
    ++count;
  });
  if (count < kMinTop_px) return std::nullopt;
  int best = 1;
  const auto window = [&](int i) {
    const auto at = static_cast<std::size_t>(i);
    return area[at - 1] + area[at] + area[at + 1];
  };
  for (int i = 2; i + 1 < kNumBins; ++i) best = window(i) > window(best) ? i : best;
  double sum = 0;
  double weight = 0;
  for (int i = best - 1; i <= best + 1; ++i) {
    sum += area[static_cast<std::size_t>(i)] * (kLowest_m + (i + 0.5) * kBin_m);
    weight += area[static_cast<std::size_t>(i)];
  }
  if (!(weight > 0)) return std::nullopt;
  return sum / weight;
}

double Cross(const Eigen::Vector2d& o, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return (a - o).x() * (b - o).y() - (a - o).y() * (b - o).x();
}

// Andrew's monotone chain.
std::vector<Eigen::Vector2d> ConvexHull(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  std::vector<Eigen::Vector2d> hull;
  const auto add = [&hull](const Eigen::Vector2d& p, std::size_t keep) {
    while (hull.size() >= keep + 2 && Cross(hull[hull.size() - 2], hull.back(), p) <= 0) {
      hull.pop_back();
    }
    hull.push_back(p);
  };
  for (const Eigen::Vector2d& p : points) add(p, 0);
  const std::size_t lower = hull.size() - 1;
  for (auto p = points.rbegin(); p != points.rend(); ++p) add(*p, lower);
  hull.pop_back();
  return hull;
}

}  // namespace

std::optional<LevelTop> ClaimLevelTop(const ImagePieces& pieces,
                                      const Plane& ground_camera,
                                      const Region& region,
                                      int owner,
                                      const SegmentOptions& options,
                                      Owners& owners) {
  const std::optional<double> height_m = DominantHeight(pieces, region);
  if (!height_m) return std::nullopt;
  std::vector<PixelPoint> top;
  region.ForEach([&](int u, int v) {
    const Eigen::Vector3f& p = pieces.points_camera(u, v);
    if (pieces.horizontal(u, v) == 0 || owners(u, v) >= 0 || !(p.z() > 0)) return;
    if (std::abs(pieces.height_m(u, v) - *height_m) <= ThicknessAt(p.z())) top.push_back({u, v, p});
  });
  const Groups groups = ConnectPoints(top, std::max(kGap_m, options.join_m));
  const int main = groups.Heaviest([](std::size_t) { return 1.0; });
  LevelTop result;
  result.height_m = *height_m;
  const Eigen::Matrix<double, 3, 2> basis = GroundTangentBasis(ground_camera.normal);
  std::vector<Eigen::Vector2d> on_ground_m;
  for (std::size_t i = 0; i < top.size(); ++i) {
    if (groups.of_point[i] != main) continue;
    owners(top[i].u, top[i].v) = owner;
    on_ground_m.emplace_back(basis.transpose() * top[i].p_camera.cast<double>());
  }
  if (on_ground_m.size() < static_cast<std::size_t>(kMinTop_px)) {
    for (const PixelPoint& p : top) {
      if (owners(p.u, p.v) == owner) owners(p.u, p.v) = -1;
    }
    return std::nullopt;
  }
  result.hull_ground_m = ConvexHull(std::move(on_ground_m));
  return result;
}

namespace {

bool IsUnder(const LevelTop& top, const Plane& ground_camera, const Eigen::Vector3d& p_camera) {
  if (ground_camera.SignedDistance(p_camera) > top.height_m + ThicknessAt(p_camera.z())) {
    return false;
  }
  const Eigen::Vector2d p = GroundTangentBasis(ground_camera.normal).transpose() * p_camera;
  const std::size_t n = top.hull_ground_m.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d& a = top.hull_ground_m[i];
    const Eigen::Vector2d& b = top.hull_ground_m[(i + 1) % n];
    if (Cross(a, b, p) < -kEdge_m * (b - a).norm()) return false;
  }
  return n >= 3;
}

}  // namespace

void ClaimCarrier(const ImagePieces& pieces,
                  const Plane& ground_camera,
                  const LevelTop& top,
                  int owner,
                  Owners& owners) {
  struct Count {
    int all = 0, above = 0, reaching = 0, under = 0;
  };
  std::vector<Count> counts(pieces.num_pixels.size());
  Mask under(owners.width(), owners.height());
  for (int v = 0; v < owners.height(); ++v) {
    for (int u = 0; u < owners.width(); ++u) {
      const std::int32_t id = pieces.piece(u, v);
      if (id < 0 || owners(u, v) >= 0) continue;
      Count& count = counts[static_cast<std::size_t>(id)];
      const Eigen::Vector3d p = pieces.points_camera(u, v).cast<double>();
      const double over_m = pieces.height_m(u, v) - top.height_m;
      ++count.all;
      count.above += over_m > ThicknessAt(p.z()) ? 1 : 0;
      count.reaching += over_m > -kReach_m && over_m <= ThicknessAt(p.z()) ? 1 : 0;
      if (pieces.horizontal(u, v) != 0 || !IsUnder(top, ground_camera, p)) continue;
      under(u, v) = 1;
      ++count.under;
    }
  }
  for (int v = 0; v < owners.height(); ++v) {
    for (int u = 0; u < owners.width(); ++u) {
      if (under(u, v) == 0) continue;
      const Count& count = counts[static_cast<std::size_t>(pieces.piece(u, v))];
      if (count.above <= kMostAbove * count.all && count.reaching >= kLeastReach * count.all &&
          2 * count.under > count.all) {
        owners(u, v) = owner;
      }
    }
  }
}

}  // namespace deepslam::segment
