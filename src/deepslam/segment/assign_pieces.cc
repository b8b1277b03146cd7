#include "deepslam/segment/assign_pieces.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace deepslam::segment {
namespace {

constexpr double kClearlyMore = 0.15;  // difference of shares that decides between regions
constexpr double kUnionShare =
    0.8;  // share of a piece that several regions must hold together to cut it

struct Claim {
  int region = 0;
  int num_pixels = 0;
};

struct Piece {
  std::int32_t id = 0;
  int num_free = 0;     // pixels that nobody owns
  int num_covered = 0;  // of them in any region
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::vector<Claim> claims;  // ascending regions

  [[nodiscard]] Eigen::Vector3d Center() const { return sum / std::max(1, num_free); }
};

// Counts and sums the pixels of claimed pieces that nobody owns.
void CountFree(const ImagePieces& pieces,
               const Owners& owners,
               const Mask& covered,
               std::vector<Piece>& survey) {
  for (int v = 0; v < owners.height(); ++v) {
    const std::int32_t* const ids = pieces.piece.row(v);
    const std::int32_t* const owner = owners.row(v);
    for (int u = 0; u < owners.width();) {
      const std::int32_t id = ids[u];
      if (id < 0 || survey[static_cast<std::size_t>(id)].claims.empty()) {
        ++u;
        continue;
      }
      // Sums of a run of pixels stay in registers.
      Piece& piece = survey[static_cast<std::size_t>(id)];
      int num_free = 0;
      int num_covered = 0;
      Eigen::Vector3d sum = piece.sum;
      for (; u < owners.width() && ids[u] == id; ++u) {
        if (owner[u] >= 0) continue;
        ++num_free;
        num_covered += covered(u, v);
        sum += pieces.points_camera(u, v).cast<double>();
      }
      piece.id = id;
      piece.num_free += num_free;
      piece.num_covered += num_covered;
      piece.sum = sum;
    }
  }
}

std::vector<Piece> Survey(const ImagePieces& pieces,
                          std::span<const Region> regions,
                          const std::vector<bool>& takes_pieces,
                          const Owners& owners) {
  std::vector<Piece> survey(pieces.num_pixels.size());
  const auto free_piece = [&](int u, int v) -> Piece* {
    const std::int32_t id = pieces.piece(u, v);
    if (id < 0 || owners(u, v) >= 0) return nullptr;
    return &survey[static_cast<std::size_t>(id)];
  };
  Mask covered(owners.width(), owners.height());
  for (std::size_t r = 0; r < regions.size(); ++r) {
    if (!takes_pieces[r]) continue;
    regions[r].ForEach([&](int u, int v) {
      Piece* piece = free_piece(u, v);
      if (piece == nullptr) return;
      covered(u, v) = 1;
      if (piece->claims.empty() || piece->claims.back().region != static_cast<int>(r)) {
        piece->claims.push_back({static_cast<int>(r), 0});
      }
      ++piece->claims.back().num_pixels;
    });
  }
  CountFree(pieces, owners, covered, survey);
  std::erase_if(survey, [](const Piece& piece) { return piece.claims.empty(); });
  std::stable_sort(survey.begin(), survey.end(), [](const Piece& a, const Piece& b) {
    return a.num_free > b.num_free;
  });
  return survey;
}

// What a region has won so far.
struct Body {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int num_pixels = 0;
};

constexpr int kNobody = -1;  // no region's claim is large enough
constexpr int kCut = -2;     // each pixel goes to its nearest region

int Winner(const Piece& piece,
           std::span<const Region> regions,
           std::span<const Body> bodies,
           const SegmentOptions& options) {
  const auto share = [&](const Claim& claim) {
    return static_cast<double>(claim.num_pixels) / piece.num_free;
  };
  double best_share = 0;
  for (const Claim& claim : piece.claims) best_share = std::max(best_share, share(claim));
  if (best_share < options.min_piece_share) {
    const bool together = piece.claims.size() > 1 &&
                          piece.num_covered >= kUnionShare * static_cast<double>(piece.num_free);
    return together ? kCut : kNobody;
  }
  int winner = kNobody;
  std::pair<double, int> best = {std::numeric_limits<double>::infinity(), 0};
  for (const Claim& claim : piece.claims) {
    if (share(claim) < std::max(options.min_piece_share, best_share - kClearlyMore)) continue;
    const auto r = static_cast<std::size_t>(claim.region);
    const Body& body = bodies[r];
    // A region that has won nothing yet stands behind those that have only if the piece is not its
    // main part.
    const double distance_m =
        body.num_pixels > 0 ? (body.sum / body.num_pixels - piece.Center()).norm() : 0.0;
    const std::pair<double, int> rank = {distance_m, regions[r].area_px()};
    if (winner == kNobody || rank < best) {
      winner = claim.region;
      best = rank;
    }
  }
  return winner;
}

// Of the regions that hold the pixel the one whose centre is nearest in units of its own size.
int NearestRegion(std::span<const Region> regions,
                  const std::vector<bool>& takes_pieces,
                  int u,
                  int v) {
  int nearest = kNobody;
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t r = 0; r < regions.size(); ++r) {
    const Region& region = regions[r];
    if (!takes_pieces[r] || !region.Contains(u, v)) continue;
    const double du = (u - 0.5 * (region.u_min + region.u_max)) / (region.u_max - region.u_min + 1);
    const double dv = (v - 0.5 * (region.v_min + region.v_max)) / (region.v_max - region.v_min + 1);
    if (du * du + dv * dv < best) {
      best = du * du + dv * dv;
      nearest = static_cast<int>(r);
    }
  }
  return nearest;
}

}  // namespace

void AssignPieces(const ImagePieces& pieces,
                  std::span<const Region> regions,
                  const std::vector<bool>& takes_pieces,
                  const SegmentOptions& options,
                  Owners& owners) {
  std::vector<Body> bodies(regions.size());
  std::vector<int> owner_of_piece(pieces.num_pixels.size(), kNobody);
  for (const Piece& piece : Survey(pieces, regions, takes_pieces, owners)) {
    const int winner = Winner(piece, regions, bodies, options);
    owner_of_piece[static_cast<std::size_t>(piece.id)] = winner;
    if (winner < 0) continue;
    Body& body = bodies[static_cast<std::size_t>(winner)];
    body.sum += piece.sum;
    body.num_pixels += piece.num_free;
  }
  for (int v = 0; v < owners.height(); ++v) {
    const std::int32_t* const ids = pieces.piece.row(v);
    std::int32_t* const owner_row = owners.row(v);
    for (int u = 0; u < owners.width(); ++u) {
      const std::int32_t id = ids[u];
      if (id < 0 || owner_row[u] >= 0) continue;
      const int owner = owner_of_piece[static_cast<std::size_t>(id)];
      if (owner == kCut) {
        owner_row[u] = NearestRegion(regions, takes_pieces, u, v);
      } else if (owner >= 0 && regions[static_cast<std::size_t>(owner)].Contains(u, v)) {
        owner_row[u] = owner;
      }
    }
  }
}

}  // namespace deepslam::segment
