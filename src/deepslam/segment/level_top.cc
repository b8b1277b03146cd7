#include "deepslam/segment/level_top.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include <Eigen/Geometry>

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
constexpr double kLeg_m = 0.15;       // parts of legs are no wider, seen from above
constexpr int kMinTop_px = 150;

double ThicknessAt(double depth_m) { return kThickness_m + kThicknessPerM2 * depth_m * depth_m; }

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

// Twice the area of a counter-clockwise polygon.
double DoubleArea(const std::vector<Eigen::Vector2d>& hull) {
  double sum = 0;
  for (std::size_t i = 1; i + 1 < hull.size(); ++i) sum += Cross(hull[0], hull[i], hull[i + 1]);
  return sum;
}

// Not farther than `margin_m` out of the hull.
bool Inside(const std::vector<Eigen::Vector2d>& hull, const Eigen::Vector2d& p, double margin_m) {
  const std::size_t n = hull.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d& a = hull[i];
    const Eigen::Vector2d& b = hull[(i + 1) % n];
    if (Cross(a, b, p) < -margin_m * (b - a).norm()) return false;
  }
  return n >= 3;
}

constexpr int kNumBins = static_cast<int>((kHighest_m - kLowest_m) / kBin_m) + 1;

// What a region holds at the heights where tops are.
class Layers {
 public:
  Layers(const ImagePieces& pieces, const Region& region, const Owners& owners);

  // Heights at which more lies than just above and below.
  [[nodiscard]] std::vector<double> PeakHeights() const;
  // The largest connected part of what is at the height: level surface, or pieces that end there,
  // as the rim of a top does whose middle returns no depth.
  [[nodiscard]] std::vector<PixelPoint> At(double height_m, const SegmentOptions& options) const;

 private:
  struct Heights {
    int all = 0;
    std::array<int, kNumBins + 1> from_bin{};  // pixels in this bin or higher; at first: in it
  };
  [[nodiscard]] bool EndsAt(std::int32_t piece, double height_m, double thickness_m) const;

  const ImagePieces* pieces_;
  std::vector<Heights> heights_;  // per piece
  std::vector<PixelPoint> points_;
};

int BinOf(double height_m) { return static_cast<int>(std::floor((height_m - kLowest_m) / kBin_m)); }

Layers::Layers(const ImagePieces& pieces, const Region& region, const Owners& owners)
    : pieces_(&pieces), heights_(pieces.num_pixels.size()) {
  for (int v = 0; v < pieces.piece.height(); ++v) {
    for (int u = 0; u < pieces.piece.width(); ++u) {
      const std::int32_t id = pieces.piece(u, v);
      if (id < 0) continue;
      Heights& heights = heights_[static_cast<std::size_t>(id)];
      ++heights.all;
      const int bin = std::min(BinOf(pieces.height_m(u, v)), kNumBins);
      if (bin >= 0) ++heights.from_bin[static_cast<std::size_t>(bin)];
    }
  }
  for (Heights& heights : heights_) {
    for (int bin = kNumBins; bin > 0; --bin) {
      heights.from_bin[static_cast<std::size_t>(bin - 1)] +=
          heights.from_bin[static_cast<std::size_t>(bin)];
    }
  }
  region.ForEach([&](int u, int v) {
    const Eigen::Vector3f p = pieces.points_camera(u, v);
    if (!(p.z() > 0) || owners(u, v) >= 0 || pieces.piece(u, v) < 0) return;
    const double height_m = pieces.height_m(u, v);
    if (height_m >= kLowest_m && height_m < kHighest_m) points_.push_back({u, v, p});
  });
}

bool Layers::EndsAt(std::int32_t piece, double height_m, double thickness_m) const {
  const Heights& heights = heights_[static_cast<std::size_t>(piece)];
  const int bin = std::clamp(BinOf(height_m + thickness_m) + 1, 0, kNumBins);
  return heights.from_bin[static_cast<std::size_t>(bin)] <= kMostAbove * heights.all;
}

std::vector<double> Layers::PeakHeights() const {
  std::vector<double> area(kNumBins, 0.0);  // pixels weigh what they cover in space
  for (const PixelPoint& p : points_) {
    const double z = p.p_camera.z();
    area[static_cast<std::size_t>(BinOf(pieces_->height_m(p.u, p.v)))] += z * z;
  }
  const auto window = [&](int i) {
    const auto at = static_cast<std::size_t>(i);
    return area[at - 1] + area[at] + area[at + 1];
  };
  std::vector<double> peaks;
  for (int i = 1; i + 1 < kNumBins; ++i) {
    if (!(window(i) > 0)) continue;
    if (i > 1 && window(i - 1) >= window(i)) continue;
    if (i + 2 < kNumBins && window(i + 1) > window(i)) continue;
    double sum = 0;
    for (int n = i - 1; n <= i + 1; ++n)
      sum += area[static_cast<std::size_t>(n)] * (kLowest_m + (n + 0.5) * kBin_m);
    peaks.push_back(sum / window(i));
  }
  return peaks;
}

std::vector<PixelPoint> Layers::At(double height_m, const SegmentOptions& options) const {
  std::vector<PixelPoint> layer;
  for (const PixelPoint& p : points_) {
    const double thickness_m = ThicknessAt(p.p_camera.z());
    if (std::abs(pieces_->height_m(p.u, p.v) - height_m) > thickness_m) continue;
    const bool level = pieces_->horizontal(p.u, p.v) != 0;
    if (level || EndsAt(pieces_->piece(p.u, p.v), height_m, thickness_m)) layer.push_back(p);
  }
  const Groups groups = ConnectPoints(layer, std::max(kGap_m, options.join_m));
  const int main = groups.Heaviest([](std::size_t) { return 1.0; });
  std::vector<PixelPoint> largest;
  for (std::size_t i = 0; i < layer.size(); ++i) {
    if (groups.of_point[i] == main) largest.push_back(layer[i]);
  }
  return largest;
}

// Share of the rays through a supposed top that end on it, of those that end on it or go on below:
// a top hides what is under it. What stands on it or before it, and rays without depth, say
// nothing.
double OpaqueShare(const ImagePieces& pieces,
                   const PinholeCamera& camera,
                   const Plane& ground_camera,
                   const Region& region,
                   const LevelTop& top) {
  constexpr int kStep_px = 2;
  if (ground_camera.d_m <= top.height_m) return 1.0;  // seen from below
  const Eigen::Matrix<double, 3, 2> basis = GroundTangentBasis(ground_camera.normal);
  int on = 0;
  int below = 0;
  for (int v = region.v_min; v <= region.v_max; v += kStep_px) {
    for (int u = region.u_min; u <= region.u_max; u += kStep_px) {
      const Eigen::Vector3f p = pieces.points_camera(u, v);
      const bool beyond = pieces.beyond(u, v) != 0;
      if (!(p.z() > 0) && !beyond) continue;
      const Eigen::Vector3d ray = camera.Ray(u, v);
      const double fall = ground_camera.normal.dot(ray);
      if (fall >= 0) continue;
      const double z_m = (top.height_m - ground_camera.d_m) / fall;
      if (!Inside(top.hull_ground_m, basis.transpose() * (z_m * ray), 0.0)) continue;
      const double over_m = beyond ? -1.0 : pieces.height_m(u, v) - top.height_m;
      const double thickness_m = ThicknessAt(z_m);
      on += std::abs(over_m) <= thickness_m ? 1 : 0;
      below += over_m < -thickness_m ? 1 : 0;
    }
  }
  return on > 0 ? static_cast<double>(on) / (on + below) : 0.0;
}

struct FoundTop {
  LevelTop top;
  std::vector<PixelPoint> pixels;
};

// The layer with the largest outline that hides what is under it. The outline counts and not the
// pixels, since dark, shiny and glass tops return depth at their rims alone while seats before them
// return all.
std::optional<FoundTop> FindTop(const ImagePieces& pieces,
                                const PinholeCamera& camera,
                                const Plane& ground_camera,
                                const Region& region,
                                const Owners& owners,
                                const SegmentOptions& options) {
  constexpr double kLeastOpaque = 0.5;
  const Eigen::Matrix<double, 3, 2> basis = GroundTangentBasis(ground_camera.normal);
  const Layers layers(pieces, region, owners);
  std::optional<FoundTop> best;
  double best_score = 0;
  for (const double height_m : layers.PeakHeights()) {
    FoundTop found;
    found.pixels = layers.At(height_m, options);
    if (found.pixels.size() < static_cast<std::size_t>(kMinTop_px)) continue;
    std::vector<Eigen::Vector2d> on_ground_m;
    for (const PixelPoint& p : found.pixels)
      on_ground_m.emplace_back(basis.transpose() * p.p_camera.cast<double>());
    found.top = {height_m, ConvexHull(std::move(on_ground_m))};
    if (found.top.hull_ground_m.size() < 3) continue;
    const double opaque = OpaqueShare(pieces, camera, ground_camera, region, found.top);
    const double score = opaque * DoubleArea(found.top.hull_ground_m);
    if (opaque < kLeastOpaque || score <= best_score) continue;
    best_score = score;
    best = std::move(found);
  }
  return best;
}

}  // namespace

std::optional<LevelTop> ClaimLevelTop(const ImagePieces& pieces,
                                      const PinholeCamera& camera,
                                      const Plane& ground_camera,
                                      const Region& region,
                                      int owner,
                                      const SegmentOptions& options,
                                      Owners& owners) {
  std::optional<FoundTop> found = FindTop(pieces, camera, ground_camera, region, owners, options);
  if (!found) return std::nullopt;
  for (const PixelPoint& p : found->pixels) owners(p.u, p.v) = owner;
  return std::move(found->top);
}

namespace {

// `p_ground_m`: the point in the ground's axes.
bool IsUnder(const LevelTop& top,
             const Plane& ground_camera,
             const Eigen::Vector3d& p_camera,
             const Eigen::Vector2d& p_ground_m) {
  if (ground_camera.SignedDistance(p_camera) > top.height_m + ThicknessAt(p_camera.z())) {
    return false;
  }
  return Inside(top.hull_ground_m, p_ground_m, kEdge_m);
}

// A piece of the image beside a top above it.
struct Support {
  int all = 0, above = 0, reaching = 0, under = 0, level = 0;
  Eigen::AlignedBox2d on_ground_m;

  [[nodiscard]] bool IsBelowTop() const { return above <= kMostAbove * all && 2 * under > all; }
  [[nodiscard]] bool IsCarrier() const {
    return IsBelowTop() && 2 * (under - level) > all && reaching >= kLeastReach * all;
  }
  [[nodiscard]] bool IsLegPart() const {
    return IsBelowTop() && !on_ground_m.isEmpty() && on_ground_m.diagonal().norm() <= kLeg_m;
  }
};

std::vector<Support> SurveySupports(const ImagePieces& pieces,
                                    const Plane& ground_camera,
                                    const LevelTop& top,
                                    const Owners& owners,
                                    Mask& under) {
  const Eigen::Matrix<double, 3, 2> basis = GroundTangentBasis(ground_camera.normal);
  std::vector<Support> supports(pieces.num_pixels.size());
  for (int v = 0; v < owners.height(); ++v) {
    for (int u = 0; u < owners.width(); ++u) {
      const std::int32_t id = pieces.piece(u, v);
      if (id < 0 || owners(u, v) >= 0) continue;
      Support& support = supports[static_cast<std::size_t>(id)];
      const Eigen::Vector3d p = pieces.points_camera(u, v).cast<double>();
      const double over_m = pieces.height_m(u, v) - top.height_m;
      ++support.all;
      support.above += over_m > ThicknessAt(p.z()) ? 1 : 0;
      support.reaching += over_m > -kReach_m && over_m <= ThicknessAt(p.z()) ? 1 : 0;
      const Eigen::Vector2d p_ground_m = basis.transpose() * p;
      support.on_ground_m.extend(p_ground_m);
      if (!IsUnder(top, ground_camera, p, p_ground_m)) continue;
      under(u, v) = 1;
      ++support.under;
      support.level += pieces.horizontal(u, v);
    }
  }
  return supports;
}

// Pieces that touch in the image and in depth, each pair once.
std::vector<std::pair<std::int32_t, std::int32_t>> TouchingPieces(const ImagePieces& pieces,
                                                                  const SegmentOptions& options) {
  std::vector<std::pair<std::int32_t, std::int32_t>> touching;
  const auto touch = [&](int u, int v, int to_u, int to_v) {
    if (!pieces.piece.Contains(to_u, to_v)) return;
    const std::int32_t a = pieces.piece(u, v);
    const std::int32_t b = pieces.piece(to_u, to_v);
    if (a < 0 || b < 0 || a == b) return;
    const double z = pieces.points_camera.z_m(u, v);
    if (std::abs(pieces.points_camera.z_m(to_u, to_v) - z) < JumpAt(z, options))
      touching.emplace_back(std::minmax(a, b));
  };
  for (int v = 0; v < pieces.piece.height(); ++v) {
    for (int u = 0; u < pieces.piece.width(); ++u) {
      touch(u, v, u + 1, v);
      touch(u, v, u, v + 1);
    }
  }
  std::sort(touching.begin(), touching.end());
  touching.erase(std::unique(touching.begin(), touching.end()), touching.end());
  return touching;
}

// 1 for pieces that carry the top: those that reach up to it, and the parts of legs that hang
// together with them, since noise cuts a leg into several pieces.
std::vector<std::uint8_t> FindCarriers(
    const std::vector<Support>& supports,
    const std::vector<std::pair<std::int32_t, std::int32_t>>& touching) {
  std::vector<std::uint8_t> carries(supports.size());
  for (std::size_t id = 0; id < supports.size(); ++id)
    carries[id] = supports[id].IsCarrier() ? 1 : 0;
  for (bool changed = true; changed;) {
    changed = false;
    for (const auto& [first, second] : touching) {
      const auto a = static_cast<std::size_t>(first);
      const auto b = static_cast<std::size_t>(second);
      if (carries[a] == carries[b] || !supports[carries[a] != 0 ? b : a].IsLegPart()) continue;
      carries[a] = carries[b] = 1;
      changed = true;
    }
  }
  return carries;
}

}  // namespace

void ClaimCarrier(const ImagePieces& pieces,
                  const Plane& ground_camera,
                  const LevelTop& top,
                  int owner,
                  const SegmentOptions& options,
                  Owners& owners) {
  Mask under(owners.width(), owners.height());
  const std::vector<Support> supports = SurveySupports(pieces, ground_camera, top, owners, under);
  const std::vector<std::uint8_t> carries = FindCarriers(supports, TouchingPieces(pieces, options));
  for (int v = 0; v < owners.height(); ++v) {
    for (int u = 0; u < owners.width(); ++u) {
      if (under(u, v) == 0) continue;
      const auto id = static_cast<std::size_t>(pieces.piece(u, v));
      const bool may_be_level = supports[id].IsLegPart();
      if (carries[id] != 0 && (may_be_level || pieces.horizontal(u, v) == 0)) owners(u, v) = owner;
    }
  }
}

}  // namespace deepslam::segment
