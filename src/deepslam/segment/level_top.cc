#include "deepslam/segment/level_top.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <Eigen/Geometry>

#include "deepslam/core/wide_vectors.h"
#include "deepslam/scene/ground.h"
#include "deepslam/segment/connect.h"
#include "deepslam/segment/outline.h"

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

constexpr int kNumBins = PieceHeights::kNumBins;
static_assert(kNumBins == static_cast<int>((kHighest_m - kLowest_m) / kBin_m) + 1);

double ThicknessAt(double depth_m) { return kThickness_m + kThicknessPerM2 * depth_m * depth_m; }

// Rounds down; below the lowest bin anything negative.
int BinOf(double height_m) {
  const double bin = (height_m - kLowest_m) / kBin_m;
  return bin < 0 ? -1 : static_cast<int>(bin);
}

DEEPSLAM_WIDE_VECTORS void FindBins(const float* height_m, int count, std::int32_t* bins) {
  for (int n = 0; n < count; ++n) {
    const double bin = (height_m[n] - kLowest_m) / kBin_m;
    bins[n] = bin < 0 ? -1 : static_cast<std::int32_t>(std::min(bin, 1.0 * kNumBins));
  }
}

// Where a point in camera axes lies on the ground.
struct GroundAxes {
  Eigen::Matrix<double, 3, 2> basis;

  explicit GroundAxes(const Plane& ground_camera)
      : basis(GroundTangentBasis(ground_camera.normal)) {}
  [[nodiscard]] double Along(int axis, double x, double y, double z) const {
    return basis(0, axis) * x + basis(1, axis) * y + basis(2, axis) * z;
  }
};

// What a region holds at the heights where tops are.
class Layers {
 public:
  Layers(const ImagePieces& pieces,
         std::span<const PieceHeights> heights,
         const Region& region,
         const Owners& owners);

  // Heights at which more lies than just above and below.
  [[nodiscard]] std::vector<double> PeakHeights() const;
  // The largest connected part of what is at the height: level surface, or pieces that end there,
  // as the rim of a top does whose middle returns no depth.
  [[nodiscard]] std::vector<PixelPoint> At(double height_m, const SegmentOptions& options) const;

 private:
  struct Pixel {
    int u, v;
  };
  [[nodiscard]] bool EndsAt(std::int32_t piece, double height_m, double thickness_m) const;

  const ImagePieces* pieces_;
  std::span<const PieceHeights> heights_;  // per piece
  std::vector<Pixel> pixels_;
  std::vector<float> height_m_;  // of the pixels
  std::vector<float> depth_m_;
};

Layers::Layers(const ImagePieces& pieces,
               std::span<const PieceHeights> heights,
               const Region& region,
               const Owners& owners)
    : pieces_(&pieces), heights_(heights) {
  region.ForEach([&](int u, int v) {
    const double height_m = pieces.height_m(u, v);
    if (!(height_m >= kLowest_m && height_m < kHighest_m)) return;
    if (pieces.piece(u, v) < 0 || owners(u, v) >= 0) return;
    pixels_.push_back({u, v});
    height_m_.push_back(pieces.height_m(u, v));
    depth_m_.push_back(pieces.points_camera.z_m(u, v));
  });
}

bool Layers::EndsAt(std::int32_t piece, double height_m, double thickness_m) const {
  const PieceHeights& heights = heights_[static_cast<std::size_t>(piece)];
  const int bin = std::clamp(BinOf(height_m + thickness_m) + 1, 0, kNumBins);
  return heights.from_bin[static_cast<std::size_t>(bin)] <= kMostAbove * heights.all;
}

std::vector<double> Layers::PeakHeights() const {
  std::vector<double> area(kNumBins, 0.0);  // pixels weigh what they cover in space
  std::vector<std::int32_t> bins(pixels_.size());
  FindBins(height_m_.data(), static_cast<int>(bins.size()), bins.data());
  for (std::size_t n = 0; n < bins.size(); ++n) {
    const double z = depth_m_[n];
    area[static_cast<std::size_t>(bins[n])] += z * z;
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

DEEPSLAM_WIDE_VECTORS void MarkNearHeight(const float* height_m,
                                          const float* depth_m,
                                          std::size_t count,
                                          double of_top_m,
                                          std::int32_t* near) {
  for (std::size_t n = 0; n < count; ++n) {
    const double z = depth_m[n];
    near[n] = std::abs(height_m[n] - of_top_m) <= ThicknessAt(z) ? 1 : 0;
  }
}

std::vector<PixelPoint> Layers::At(double height_m, const SegmentOptions& options) const {
  std::vector<std::int32_t> near(pixels_.size());
  MarkNearHeight(height_m_.data(), depth_m_.data(), near.size(), height_m, near.data());
  std::vector<PixelPoint> layer;
  for (std::size_t n = 0; n < near.size(); ++n) {
    if (near[n] == 0) continue;
    const auto [u, v] = pixels_[n];
    const bool level = pieces_->horizontal(u, v) != 0;
    if (level || EndsAt(pieces_->piece(u, v), height_m, ThicknessAt(depth_m_[n])))
      layer.push_back({u, v, pieces_->points_camera(u, v)});
  }
  const Groups groups = ConnectPoints(layer, std::max(kGap_m, options.join_m));
  if (groups.count == 1) return layer;
  const int main = groups.Heaviest([](std::size_t) { return 1.0; });
  std::vector<PixelPoint> largest;
  for (std::size_t i = 0; i < layer.size(); ++i) {
    if (groups.of_point[i] == main) largest.push_back(layer[i]);
  }
  return largest;
}

// Where the rays through a row of the image, every other pixel, meet the height of a top.
struct RowAtHeight {
  explicit RowAtHeight(std::size_t size) : z_m(size), x_ground_m(size), y_ground_m(size) {}

  std::vector<double> z_m;  // not above 0: they do not meet it
  std::vector<double> x_ground_m;
  std::vector<double> y_ground_m;
};

DEEPSLAM_WIDE_VECTORS void MeetHeight(const std::vector<double>& rays_x,
                                      double ray_y,
                                      const Plane& ground_camera,
                                      const GroundAxes& axes,
                                      double height_m,
                                      RowAtHeight& row) {
  const double from_camera_m = height_m - ground_camera.d_m;
  const Plane ground = ground_camera;
  const GroundAxes on_ground = axes;
  const double* const ray_x = rays_x.data();
  double* const z_m = row.z_m.data();
  double* const x_ground_m = row.x_ground_m.data();
  double* const y_ground_m = row.y_ground_m.data();
  const std::size_t count = rays_x.size();
#pragma GCC ivdep
  for (std::size_t n = 0; n < count; ++n) {
    const double fall =
        ground.normal.x() * ray_x[n] + ground.normal.y() * ray_y + ground.normal.z();
    const double z = from_camera_m / fall;
    const double x = z * ray_x[n];
    const double y = z * ray_y;
    x_ground_m[n] = on_ground.Along(0, x, y, z);
    y_ground_m[n] = on_ground.Along(1, x, y, z);
    z_m[n] = fall < 0 ? z : 0.0;
  }
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
  const GroundAxes axes(ground_camera);
  std::vector<double> rays_x;
  for (int u = region.u_min; u <= region.u_max; u += kStep_px)
    rays_x.push_back(camera.Ray(u, 0).x());
  RowAtHeight row(rays_x.size());
  WithinHull within(top.hull_ground_m, 0.0);
  int on = 0;
  int below = 0;
  for (int v = region.v_min; v <= region.v_max; v += kStep_px) {
    MeetHeight(rays_x, camera.Ray(0, v).y(), ground_camera, axes, top.height_m, row);
    for (std::size_t n = 0; n < rays_x.size(); ++n) {
      const int u = region.u_min + kStep_px * static_cast<int>(n);
      const bool beyond = pieces.beyond(u, v) != 0;
      if (!(pieces.points_camera.z_m(u, v) > 0) && !beyond) continue;
      if (!(row.z_m[n] > 0) || !within(row.x_ground_m[n], row.y_ground_m[n])) continue;
      const double over_m = beyond ? -1.0 : pieces.height_m(u, v) - top.height_m;
      const double thickness_m = ThicknessAt(row.z_m[n]);
      on += std::abs(over_m) <= thickness_m ? 1 : 0;
      below += over_m < -thickness_m ? 1 : 0;
    }
  }
  return on > 0 ? static_cast<double>(on) / (on + below) : 0.0;
}

PlanarPoints OnGround(std::span<const PixelPoint> pixels, const GroundAxes& axes) {
  PlanarPoints on_ground;
  on_ground.x_m.reserve(pixels.size());
  on_ground.y_m.reserve(pixels.size());
  for (const PixelPoint& pixel : pixels) {
    const Eigen::Vector3d p = pixel.p_camera.cast<double>();
    on_ground.x_m.push_back(axes.Along(0, p.x(), p.y(), p.z()));
    on_ground.y_m.push_back(axes.Along(1, p.x(), p.y(), p.z()));
  }
  return on_ground;
}

struct FoundTop {
  LevelTop top;
  std::vector<PixelPoint> pixels;
};

// The layer with the largest outline that hides what is under it. The outline counts and not the
// pixels, since dark, shiny and glass tops return depth at their rims alone while seats before them
// return all.
std::optional<FoundTop> FindTop(const ImagePieces& pieces,
                                std::span<const PieceHeights> heights,
                                const PinholeCamera& camera,
                                const Plane& ground_camera,
                                const Region& region,
                                const Owners& owners,
                                const SegmentOptions& options) {
  constexpr double kLeastOpaque = 0.5;
  const GroundAxes axes(ground_camera);
  const Layers layers(pieces, heights, region, owners);
  std::optional<FoundTop> best;
  double best_score = 0;
  for (const double height_m : layers.PeakHeights()) {
    FoundTop found;
    found.pixels = layers.At(height_m, options);
    if (found.pixels.size() < static_cast<std::size_t>(kMinTop_px)) continue;
    found.top = {height_m, ConvexHull(OnGround(found.pixels, axes))};
    if (found.top.hull_ground_m.size() < 3) continue;
    // The share is 1 at most.
    const double double_area_m2 = DoubleArea(found.top.hull_ground_m);
    if (double_area_m2 <= best_score) continue;
    const double opaque = OpaqueShare(pieces, camera, ground_camera, region, found.top);
    const double score = opaque * double_area_m2;
    if (opaque < kLeastOpaque || score <= best_score) continue;
    best_score = score;
    best = std::move(found);
  }
  return best;
}

}  // namespace

std::vector<PieceHeights> HeightsOf(const ImagePieces& pieces) {
  std::vector<PieceHeights> heights(pieces.num_pixels.size());
  const int width = pieces.piece.width();
  std::vector<std::int32_t> bins(static_cast<std::size_t>(width));
  for (int v = 0; v < pieces.piece.height(); ++v) {
    FindBins(pieces.height_m.row(v), width, bins.data());
    const std::int32_t* const piece = pieces.piece.row(v);
    for (int u = 0; u < width; ++u) {
      if (piece[u] < 0) continue;
      PieceHeights& of_piece = heights[static_cast<std::size_t>(piece[u])];
      ++of_piece.all;
      const std::int32_t bin = bins[static_cast<std::size_t>(u)];
      if (bin >= 0) ++of_piece.from_bin[static_cast<std::size_t>(bin)];
    }
  }
  for (PieceHeights& of_piece : heights) {
    for (std::size_t bin = kNumBins; bin > 0; --bin) {
      of_piece.from_bin[bin - 1] += of_piece.from_bin[bin];
    }
  }
  return heights;
}

std::optional<LevelTop> ClaimLevelTop(const ImagePieces& pieces,
                                      std::span<const PieceHeights> heights,
                                      const PinholeCamera& camera,
                                      const Plane& ground_camera,
                                      const Region& region,
                                      int owner,
                                      const SegmentOptions& options,
                                      Owners& owners) {
  std::optional<FoundTop> found =
      FindTop(pieces, heights, camera, ground_camera, region, owners, options);
  if (!found) return std::nullopt;
  for (const PixelPoint& p : found->pixels) owners(p.u, p.v) = owner;
  return std::move(found->top);
}

namespace {

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

// How a row's points lie to a top.
struct RowUnderTop {
  explicit RowUnderTop(int width)
      : x_ground_m(static_cast<std::size_t>(width)),
        y_ground_m(x_ground_m.size()),
        relation(x_ground_m.size()) {}

  enum Relation : std::int32_t { kAbove = 1, kReaching = 2, kLowEnough = 4 };

  std::vector<double> x_ground_m;
  std::vector<double> y_ground_m;
  std::vector<std::int32_t> relation;
};

DEEPSLAM_WIDE_VECTORS void CompareRow(const ImagePieces& pieces,
                                      const Plane& ground_camera,
                                      const GroundAxes& axes,
                                      double of_top_m,
                                      int v,
                                      RowUnderTop& row) {
  const float* const x_row = pieces.points_camera.x_row(v);
  const float* const y_row = pieces.points_camera.y_row(v);
  const float* const z_row = pieces.points_camera.z_row(v);
  const float* const height_m = pieces.height_m.row(v);
  const Eigen::Vector3d& up = ground_camera.normal;
  const std::size_t width = row.relation.size();
  for (std::size_t u = 0; u < width; ++u) {
    const double x = x_row[u];
    const double y = y_row[u];
    const double z = z_row[u];
    const double over_m = height_m[u] - of_top_m;
    const double thickness_m = ThicknessAt(z);
    const double from_ground_m = up.x() * x + up.y() * y + up.z() * z + ground_camera.d_m;
    const bool above = over_m > thickness_m;
    const bool reaching = (over_m > -kReach_m) & (over_m <= thickness_m);
    const bool low_enough = from_ground_m <= of_top_m + thickness_m;
    row.relation[u] = (above ? RowUnderTop::kAbove : 0) | (reaching ? RowUnderTop::kReaching : 0) |
                      (low_enough ? RowUnderTop::kLowEnough : 0);
    row.x_ground_m[u] = axes.Along(0, x, y, z);
    row.y_ground_m[u] = axes.Along(1, x, y, z);
  }
}

std::vector<Support> SurveySupports(const ImagePieces& pieces,
                                    const Plane& ground_camera,
                                    const LevelTop& top,
                                    const Owners& owners,
                                    Mask& under) {
  const GroundAxes axes(ground_camera);
  WithinHull within(top.hull_ground_m, kEdge_m);
  RowUnderTop row(owners.width());
  std::vector<Support> supports(pieces.num_pixels.size());
  for (int v = 0; v < owners.height(); ++v) {
    CompareRow(pieces, ground_camera, axes, top.height_m, v, row);
    const std::int32_t* const ids = pieces.piece.row(v);
    const std::int32_t* const owner = owners.row(v);
    const std::uint8_t* const level = pieces.horizontal.row(v);
    std::uint8_t* const is_under = under.row(v);
    for (int u = 0; u < owners.width();) {
      const std::int32_t id = ids[u];
      if (id < 0) {
        ++u;
        continue;
      }
      // What a run of pixels adds stays in registers.
      Support support = supports[static_cast<std::size_t>(id)];
      for (; u < owners.width() && ids[u] == id; ++u) {
        if (owner[u] >= 0) continue;
        const auto at = static_cast<std::size_t>(u);
        const std::int32_t relation = row.relation[at];
        ++support.all;
        support.above += (relation & RowUnderTop::kAbove) != 0 ? 1 : 0;
        support.reaching += (relation & RowUnderTop::kReaching) != 0 ? 1 : 0;
        const double x_m = row.x_ground_m[at];
        const double y_m = row.y_ground_m[at];
        support.on_ground_m.extend(Eigen::Vector2d(x_m, y_m));
        if ((relation & RowUnderTop::kLowEnough) == 0 || !within(x_m, y_m)) continue;
        is_under[u] = 1;
        ++support.under;
        support.level += level[u];
      }
      supports[static_cast<std::size_t>(id)] = support;
    }
  }
  return supports;
}

using Touch = std::pair<std::int32_t, std::int32_t>;

// Pieces that touch in the image and in depth, each pair once.
std::vector<Touch> TouchingPieces(const ImagePieces& pieces, const SegmentOptions& options) {
  std::vector<Touch> touching;
  const auto touch = [&](std::int32_t a, std::int32_t b, float z, float z_to) {
    if (a == b || a < 0 || b < 0) return;
    if (!(std::abs(static_cast<double>(z_to) - z) < JumpAt(z, options))) return;
    const Touch pair = std::minmax(a, b);
    if (touching.empty() || touching.back() != pair) touching.push_back(pair);
  };
  const int width = pieces.piece.width();
  const int height = pieces.piece.height();
  for (int v = 0; v < height; ++v) {
    const std::int32_t* const ids = pieces.piece.row(v);
    const float* const z_m = pieces.points_camera.z_row(v);
    for (int u = 0; u + 1 < width; ++u) touch(ids[u], ids[u + 1], z_m[u], z_m[u + 1]);
    if (v + 1 == height) continue;
    const std::int32_t* const ids_below = pieces.piece.row(v + 1);
    const float* const z_below_m = pieces.points_camera.z_row(v + 1);
    for (int u = 0; u < width; ++u) touch(ids[u], ids_below[u], z_m[u], z_below_m[u]);
  }
  std::sort(touching.begin(), touching.end());
  touching.erase(std::unique(touching.begin(), touching.end()), touching.end());
  return touching;
}

// 1 for pieces that carry the top: those that reach up to it, and the parts of legs that hang
// together with them, since noise cuts a leg into several pieces.
std::vector<std::uint8_t> FindCarriers(const std::vector<Support>& supports,
                                       const std::vector<Touch>& touching) {
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

void ClaimCarrier(const ImagePieces& pieces,
                  const Plane& ground_camera,
                  const OwnedTop& top,
                  const std::vector<Touch>& touching,
                  Owners& owners) {
  Mask under(owners.width(), owners.height());
  const std::vector<Support> supports =
      SurveySupports(pieces, ground_camera, top.top, owners, under);
  const std::vector<std::uint8_t> carries = FindCarriers(supports, touching);
  for (int v = 0; v < owners.height(); ++v) {
    const std::uint8_t* const is_under = under.row(v);
    for (int u = 0; u < owners.width(); ++u) {
      if (is_under[u] == 0) continue;
      const auto id = static_cast<std::size_t>(pieces.piece(u, v));
      if (carries[id] == 0) continue;
      const bool may_be_level = supports[id].IsLegPart();
      if (may_be_level || pieces.horizontal(u, v) == 0) owners(u, v) = top.owner;
    }
  }
}

}  // namespace

void ClaimCarriers(const ImagePieces& pieces,
                   const Plane& ground_camera,
                   std::span<const OwnedTop> tops,
                   const SegmentOptions& options,
                   Owners& owners) {
  if (tops.empty()) return;
  const std::vector<Touch> touching = TouchingPieces(pieces, options);
  for (const OwnedTop& top : tops) ClaimCarrier(pieces, ground_camera, top, touching, owners);
}

}  // namespace deepslam::segment
