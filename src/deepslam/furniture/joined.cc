#include "deepslam/furniture/joined.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "deepslam/scene/mesh_box.h"

namespace deepslam::furniture {

namespace {

constexpr double kLowestSeat = 0.25;  // shares of the model's height
constexpr double kHighestSeat = 0.67;
constexpr double kLeastOpen = 0.25;  // share of the ground plan's voxels
constexpr int kThickness = 3;        // voxels: cushions are not flat

struct Corner {
  Eigen::Vector3f place;
  Rgb8 colour;
};

// Where the edge meets the plane; the colour of the nearer end.
Corner CrossingAt(const Corner& a, const Corner& b, float z) {
  const float share = (z - a.place.z()) / (b.place.z() - a.place.z());
  Corner crossing{a.place + share * (b.place - a.place), share < 0.5F ? a.colour : b.colour};
  crossing.place.z() = z;
  return crossing;
}

// The part of a face above the plane (or below it): up to four corners (Sutherland, Hodgman 1974).
std::vector<Corner> Cut(const std::array<Corner, 3>& face, float z, bool above) {
  std::vector<Corner> kept;
  for (std::size_t c = 0; c < 3; ++c) {
    const Corner& here = face[c];
    const Corner& next = face[(c + 1) % 3];
    const bool here_kept = (here.place.z() >= z) == above;
    const bool next_kept = (next.place.z() >= z) == above;
    if (here_kept) kept.push_back(here);
    if (here_kept != next_kept) kept.push_back(CrossingAt(here, next, z));
  }
  return kept;
}

template <typename Move>
void AddPart(
    const TriangleMesh& mesh, float z, bool above, const Move& move, TriangleMesh& joined) {
  for (const auto& face : mesh.faces) {
    std::array<Corner, 3> whole;
    for (std::size_t c = 0; c < 3; ++c) {
      whole[c] = {mesh.vertices[face[c]],
                  mesh.colours.empty() ? Rgb8{200, 200, 200} : mesh.colours[face[c]]};
    }
    const std::vector<Corner> part = Cut(whole, z, above);
    for (std::size_t c = 2; c < part.size(); ++c) {
      const auto first = static_cast<std::uint32_t>(joined.vertices.size());
      joined.faces.push_back({first, first + 1, first + 2});
      for (const Corner& corner : {part[0], part[c - 1], part[c]}) {
        joined.vertices.push_back(move(corner.place));
        joined.colours.push_back(corner.colour);
      }
    }
  }
}

}  // namespace

std::optional<float> SeatHeight(const VoxelGrid& shape) {
  const std::optional<VoxelBox> box = OccupiedBox(shape);
  if (!box) return std::nullopt;
  std::vector<int> open(kGridSize, 0);  // voxels of each layer with nothing right above them
  int plan = 0;
  for (int i = box->low.x(); i <= box->high.x(); ++i) {
    for (int j = box->low.y(); j <= box->high.y(); ++j) {
      bool any = false;
      for (int k = box->low.z(); k <= box->high.z(); ++k) {
        if (!shape.At(i, j, k)) continue;
        any = true;
        const bool covered = k + 1 < kGridSize && shape.At(i, j, k + 1);
        open[static_cast<std::size_t>(k)] += covered ? 0 : 1;
      }
      plan += any ? 1 : 0;
    }
  }
  const double height = box->sides().z();
  std::pair<int, int> best = {0, 0};  // open voxels, layer
  for (int k = box->low.z(); k <= box->high.z(); ++k) {
    const double share = (k - box->low.z() + 1) / height;
    if (share < kLowestSeat || share > kHighestSeat) continue;
    int sum = 0;
    for (int n = std::max(box->low.z(), k - kThickness + 1); n <= k; ++n)
      sum += open[static_cast<std::size_t>(n)];
    best = std::max(best, {sum, k});
  }
  if (best.first < kLeastOpen * plan) return std::nullopt;
  return static_cast<float>((best.second - box->low.z() + 1) / height);
}

TriangleMesh JoinAtSeat(const SeatMesh& lower, const SeatMesh& upper) {
  TriangleMesh joined;
  const Eigen::AlignedBox3f below = BoxOfFaces(lower.mesh);
  const Eigen::AlignedBox3f above = BoxOfFaces(upper.mesh);
  const float lower_seat = below.min().z() + lower.seat_height * below.sizes().z();
  const float upper_seat = above.min().z() + upper.seat_height * above.sizes().z();
  Eigen::Vector3f scale = below.sizes().cwiseQuotient(above.sizes().cwiseMax(1e-6F));
  scale.z() = 1;
  const Eigen::Vector3f from(above.center().x(), above.center().y(), upper_seat);
  const Eigen::Vector3f to(below.center().x(), below.center().y(), lower_seat);
  AddPart(
      lower.mesh, lower_seat, false, [](const Eigen::Vector3f& p) { return p; }, joined);
  AddPart(
      upper.mesh,
      upper_seat,
      true,
      [&](const Eigen::Vector3f& p) -> Eigen::Vector3f {
        return to + scale.cwiseProduct(p - from);
      },
      joined);
  return joined;
}

}  // namespace deepslam::furniture
