#include "deepslam/segment/top_carriers.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "deepslam/core/wide_vectors.h"
#include "deepslam/segment/outline.h"

namespace deepslam::segment {
namespace {

constexpr double kEdge_m = 0.04;          // legs may stand this far out of the visible top
constexpr double kCarrierReach_m = 0.12;  // what carries a top is seen up to this close below it
constexpr double kLeastReach = 0.01;      // share of a piece's pixels that must come close to it
constexpr double kLeg_m = 0.15;           // parts of legs are no wider, seen from above

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
    const double thickness_m = TopThicknessAt(z);
    const double from_ground_m = up.x() * x + up.y() * y + up.z() * z + ground_camera.d_m;
    const bool above = over_m > thickness_m;
    const bool reaching = (over_m > -kCarrierReach_m) & (over_m <= thickness_m);
    const bool low_enough = from_ground_m <= of_top_m + thickness_m;
    row.relation[u] = (above ? RowUnderTop::kAbove : 0) | (reaching ? RowUnderTop::kReaching : 0) |
                      (low_enough ? RowUnderTop::kLowEnough : 0);
    row.x_ground_m[u] = axes.Along(0, x, y, z);
    row.y_ground_m[u] = axes.Along(1, x, y, z);
  }
}

std::vector<Support> SurveySupports(const ImagePieces& pieces,
                                    const Plane& ground_camera,
                                    const SupportPlane& top,
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
std::vector<Touch> TouchingPieces(const ImagePieces& pieces) {
  std::vector<Touch> touching;
  const auto touch = [&](std::int32_t a, std::int32_t b, float z, float z_to) {
    if (a == b || a < 0 || b < 0) return;
    if (!(std::abs(static_cast<double>(z_to) - z) < JumpAt(z))) return;
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
                   Owners& owners) {
  if (tops.empty()) return;
  const std::vector<Touch> touching = TouchingPieces(pieces);
  for (const OwnedTop& top : tops) ClaimCarrier(pieces, ground_camera, top, touching, owners);
}

}  // namespace deepslam::segment
