#include "deepslam/segment/top_heights.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "deepslam/core/wide_vectors.h"

namespace deepslam::segment {
namespace {

// Tops of tables and desks, from coffee tables to bars; lower ones are seats and shelves.
constexpr double kLowestTop_m = 0.30;
constexpr double kHighestTop_m = 1.30;  // a bar is 1.1 m high
constexpr double kBin_m = 0.02;      // a peak takes three: a top and its noise
constexpr double kTopGap_m =
    0.30;  // parts of a top hidden from each other by what stands before it

constexpr int kNumBins = PieceHeights::kNumBins;
static_assert(kNumBins == static_cast<int>((kHighestTop_m - kLowestTop_m) / kBin_m) + 1);

// Rounds down; below the lowest bin anything negative.
int BinOf(double height_m) {
  const double bin = (height_m - kLowestTop_m) / kBin_m;
  return bin < 0 ? -1 : static_cast<int>(bin);
}

DEEPSLAM_WIDE_VECTORS void FindBins(const float* height_m, int count, std::int32_t* bins) {
  for (int n = 0; n < count; ++n) {
    const double bin = (height_m[n] - kLowestTop_m) / kBin_m;
    bins[n] = bin < 0 ? -1 : static_cast<std::int32_t>(std::min(bin, 1.0 * kNumBins));
  }
}

DEEPSLAM_WIDE_VECTORS void MarkNearHeight(const float* height_m,
                                          const float* depth_m,
                                          std::size_t count,
                                          double of_top_m,
                                          std::int32_t* near) {
  for (std::size_t n = 0; n < count; ++n) {
    const double z = depth_m[n];
    near[n] = std::abs(height_m[n] - of_top_m) <= TopThicknessAt(z) ? 1 : 0;
  }
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

HeightLayers::HeightLayers(const ImagePieces& pieces,
                           std::span<const PieceHeights> heights,
                           const Region& region,
                           const Owners& owners)
    : pieces_(&pieces), heights_(heights) {
  region.ForEach([&](int u, int v) {
    const double height_m = pieces.height_m(u, v);
    if (!(height_m >= kLowestTop_m && height_m < kHighestTop_m)) return;
    if (pieces.piece(u, v) < 0 || owners(u, v) >= 0) return;
    pixels_.push_back({u, v});
    height_m_.push_back(pieces.height_m(u, v));
    depth_m_.push_back(pieces.points_camera.z_m(u, v));
  });
}

bool HeightLayers::EndsAt(std::int32_t piece, double height_m, double thickness_m) const {
  const PieceHeights& heights = heights_[static_cast<std::size_t>(piece)];
  const int bin = std::clamp(BinOf(height_m + thickness_m) + 1, 0, kNumBins);
  return heights.from_bin[static_cast<std::size_t>(bin)] <= kMostAbove * heights.all;
}

std::vector<double> HeightLayers::PeakHeights() const {
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
      sum += area[static_cast<std::size_t>(n)] * (kLowestTop_m + (n + 0.5) * kBin_m);
    peaks.push_back(sum / window(i));
  }
  return peaks;
}

std::vector<PixelPoint> HeightLayers::At(double height_m) const {
  std::vector<std::int32_t> near(pixels_.size());
  MarkNearHeight(height_m_.data(), depth_m_.data(), near.size(), height_m, near.data());
  std::vector<PixelPoint> layer;
  for (std::size_t n = 0; n < near.size(); ++n) {
    if (near[n] == 0) continue;
    const auto [u, v] = pixels_[n];
    const bool level = pieces_->horizontal(u, v) != 0;
    if (level || EndsAt(pieces_->piece(u, v), height_m, TopThicknessAt(depth_m_[n])))
      layer.push_back({u, v, pieces_->points_camera(u, v)});
  }
  const Groups groups = ConnectPoints(layer, std::max(kTopGap_m, SegmentOptions::kJoin_m));
  if (groups.count == 1) return layer;
  const int main = groups.Heaviest([](std::size_t) { return 1.0; });
  std::vector<PixelPoint> largest;
  for (std::size_t i = 0; i < layer.size(); ++i) {
    if (groups.of_point[i] == main) largest.push_back(layer[i]);
  }
  return largest;
}

}  // namespace deepslam::segment
