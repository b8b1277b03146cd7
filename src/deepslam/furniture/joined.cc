#include "deepslam/furniture/joined.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "deepslam/furniture/face_corners.h"
#include "deepslam/scene/mesh_box.h"

namespace deepslam::furniture {

namespace {

constexpr double kLowestSeat = 0.25;   // shares of the model's height
constexpr double kHighestSeat = 0.67;  // higher layers are armrests or the top of the back
constexpr double kLeastOpen = 0.25;    // share of the ground plan's voxels
constexpr int kThickness = 3;          // voxels: cushions are not flat

// Where the edge meets the plane; the colour of the nearer end.
Corner CrossingAt(const Corner& a, const Corner& b, float z) {
  const float share = (z - a.place.z()) / (b.place.z() - a.place.z());
  Corner crossing{a.place + share * (b.place - a.place), share < 0.5F ? a.colour : b.colour};
  crossing.place.z() = z;
  return crossing;
}

// The part of a face above the plane (or below it): up to four corners (Sutherland, Hodgman 1974).
std::vector<Corner> Cut(const Face& face, float z, bool above) {
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

void AddPart(const TriangleMesh& mesh, float z, bool above, TriangleMesh& joined) {
  for (const auto& face : mesh.faces) {
    const std::vector<Corner> part = Cut(CornersOf(mesh, face), z, above);
    for (std::size_t c = 2; c < part.size(); ++c) AddFace({part[0], part[c - 1], part[c]}, joined);
  }
}

// Level faces over what is solid at height z, a strip for each run of voxels along y.
void AddCap(const SeatMesh& seat, float z, TriangleMesh& joined) {
  const Eigen::AlignedBox3f box = BoxOfFaces(seat.mesh);
  const float voxel = box.sizes().maxCoeff() / (static_cast<float>(kModelExtent) * kGridSize);
  const auto edge = [&](int axis, int n) {
    const float at = box.center()[axis] + voxel * static_cast<float>(n - kGridSize / 2);
    return std::clamp(at, box.min()[axis], box.max()[axis]);
  };
  const int k = kGridSize / 2 + static_cast<int>(std::floor((z - box.center().z()) / voxel));
  const auto is_solid = [&](int i, int j) {
    return VoxelGrid::Contains(i, j, k) && seat.shape.At(i, j, k);
  };
  const Rgb8 colour = CornersOf(seat.mesh, seat.mesh.faces.front())[0].colour;
  for (int i = 0; i < kGridSize; ++i) {
    for (int from = 0; from < kGridSize; ++from) {
      if (!is_solid(i, from)) continue;
      int to = from;
      while (is_solid(i, to)) ++to;
      const std::array corners = {Corner{{edge(0, i), edge(1, from), z}, colour},
                                  Corner{{edge(0, i + 1), edge(1, from), z}, colour},
                                  Corner{{edge(0, i + 1), edge(1, to), z}, colour},
                                  Corner{{edge(0, i), edge(1, to), z}, colour}};
      AddFace({corners[0], corners[1], corners[2]}, joined);
      AddFace({corners[0], corners[2], corners[3]}, joined);
      from = to;
    }
  }
}

// One side of the cut, closed.
TriangleMesh PartOf(const SeatMesh& seat, float z, bool above) {
  TriangleMesh part;
  if (seat.mesh.empty()) return part;
  AddPart(seat.mesh, z, above, part);
  AddCap(seat, z, part);
  return part;
}

float SeatOf(const SeatMesh& seat, const Eigen::AlignedBox3f& box) {
  return box.min().z() + seat.seat_height * box.sizes().z();
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
  const Eigen::AlignedBox3f below = BoxOfFaces(lower.mesh);
  const Eigen::AlignedBox3f above = BoxOfFaces(upper.mesh);
  const float lower_seat = SeatOf(lower, below);
  const float upper_seat = SeatOf(upper, above);
  Eigen::Vector3f scale = below.sizes().cwiseQuotient(above.sizes().cwiseMax(1e-6F));
  scale.z() = 1;
  const Eigen::Vector3f from(above.center().x(), above.center().y(), upper_seat);
  const Eigen::Vector3f to(below.center().x(), below.center().y(), lower_seat);
  TriangleMesh joined = PartOf(lower, lower_seat, false);
  const TriangleMesh back = PartOf(upper, upper_seat, true);
  for (const auto& face : back.faces) {
    Face moved = CornersOf(back, face);
    for (Corner& corner : moved) corner.place = to + scale.cwiseProduct(corner.place - from);
    AddFace(moved, joined);
  }
  return joined;
}

}  // namespace deepslam::furniture
