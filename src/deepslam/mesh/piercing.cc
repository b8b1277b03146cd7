#include "deepslam/mesh/piercing.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "deepslam/mesh/closed_manifold.h"

namespace deepslam::mesh {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Face = std::array<std::uint32_t, 3>;

// Finds boxes that meet: they are put into slabs across the longest axis of them all, and those of
// a slab are gone through along another.
class MeetingBoxes {
 public:
  explicit MeetingBoxes(std::vector<Eigen::AlignedBox3f> boxes) : boxes_(std::move(boxes)) {
    for (const Eigen::AlignedBox3f& box : boxes_) all_.extend(box);
    all_.sizes().maxCoeff(&across_);
    along_ = (across_ + 1) % 3;
    slabs_.resize(1 + static_cast<std::size_t>(std::sqrt(static_cast<double>(boxes_.size()))));
    for (std::uint32_t n = 0; n < boxes_.size(); ++n) {
      const std::size_t last = SlabOf(boxes_[n].max());
      for (std::size_t slab = SlabOf(boxes_[n].min()); slab <= last; ++slab)
        slabs_[slab].push_back(n);
    }
    for (std::vector<std::uint32_t>& slab : slabs_) {
      std::ranges::sort(slab, {}, [&](std::uint32_t n) { return boxes_[n].min()[along_]; });
    }
  }

  // Whether visit(a, b) holds for any pair; each pair is asked about once.
  template <typename Visit>
  [[nodiscard]] bool Any(const Visit& visit) const {
    for (std::size_t slab = 0; slab < slabs_.size(); ++slab) {
      const std::vector<std::uint32_t>& own = slabs_[slab];
      for (std::size_t i = 0; i < own.size(); ++i) {
        const Eigen::AlignedBox3f& box = boxes_[own[i]];
        for (std::size_t j = i + 1; j < own.size(); ++j) {
          const Eigen::AlignedBox3f& other = boxes_[own[j]];
          if (other.min()[along_] > box.max()[along_]) break;
          // Two that lie in several slabs together are met in the first of them.
          if (box.intersects(other) && SlabOf(box.min().cwiseMax(other.min())) == slab &&
              visit(own[i], own[j])) {
            return true;
          }
        }
      }
    }
    return false;
  }

 private:
  [[nodiscard]] std::size_t SlabOf(const Eigen::Vector3f& p) const {
    const float length = all_.sizes()[across_];
    const float share = length > 0 ? (p[across_] - all_.min()[across_]) / length : 0.0F;
    return std::min(static_cast<std::size_t>(share * static_cast<float>(slabs_.size())),
                    slabs_.size() - 1);
  }

  std::vector<Eigen::AlignedBox3f> boxes_;
  Eigen::AlignedBox3f all_;
  Eigen::Index across_ = 0;
  Eigen::Index along_ = 0;
  std::vector<std::vector<std::uint32_t>> slabs_;
};

// Corners of one face among those of another.
struct Shared {
  std::size_t count = 0;
  std::array<bool, 3> of_first{};
  std::array<bool, 3> of_second{};
};

Shared SharedCorners(const Face& first, const Face& second) {
  Shared shared;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (first[i] != second[j]) continue;
      ++shared.count;
      shared.of_first[i] = true;
      shared.of_second[j] = true;
    }
  }
  return shared;
}

std::size_t PlaceOf(const std::array<bool, 3>& corners, bool wanted) {
  return static_cast<std::size_t>(std::find(corners.begin(), corners.end(), wanted) -
                                  corners.begin());
}

// Faces of a closed manifold; the tests are those of CGAL's self_intersections.
class Faces {
 public:
  explicit Faces(const TriangleMesh& mesh) : faces_(mesh.faces) {
    points_.reserve(mesh.vertices.size());
    for (const Eigen::Vector3f& p : mesh.vertices) points_.emplace_back(p.x(), p.y(), p.z());
  }

  [[nodiscard]] bool HasNoArea(const Face& face) const {
    return CGAL::collinear(points_[face[0]], points_[face[1]], points_[face[2]]);
  }

  [[nodiscard]] bool Meet(std::uint32_t a, std::uint32_t b) const {
    const Face& first = faces_[a];
    const Face& second = faces_[b];
    const Shared shared = SharedCorners(first, second);
    if (shared.count >= 2) return FoldOver(first, second, shared);
    if (shared.count == 0) return CGAL::do_intersect(Triangle(first), Triangle(second));
    return CGAL::do_intersect(Triangle(first), Opposite(second, PlaceOf(shared.of_second, true))) ||
           CGAL::do_intersect(Triangle(second), Opposite(first, PlaceOf(shared.of_first, true)));
  }

 private:
  // Neighbours across an edge that lie in one plane, on one side of it.
  [[nodiscard]] bool FoldOver(const Face& first, const Face& second, const Shared& shared) const {
    if (shared.count == 3) return true;  // one face twice
    const std::size_t third = PlaceOf(shared.of_first, false);
    const auto& p = points_[first[(third + 1) % 3]];
    const auto& q = points_[first[(third + 2) % 3]];
    const auto& r = points_[first[third]];
    const auto& s = points_[second[PlaceOf(shared.of_second, false)]];
    return CGAL::coplanar(p, q, r, s) && CGAL::coplanar_orientation(p, q, r, s) == CGAL::POSITIVE;
  }

  [[nodiscard]] Kernel::Triangle_3 Triangle(const Face& face) const {
    return {points_[face[0]], points_[face[1]], points_[face[2]]};
  }
  [[nodiscard]] Kernel::Segment_3 Opposite(const Face& face, std::size_t corner) const {
    return {points_[face[(corner + 1) % 3]], points_[face[(corner + 2) % 3]]};
  }

  const std::vector<Face>& faces_;
  std::vector<Kernel::Point_3> points_;
};

}  // namespace

std::optional<bool> PiercesItself(const TriangleMesh& mesh) {
  if (mesh.faces.empty() || !IsClosedManifold(mesh.faces, mesh.vertices.size()))
    return std::nullopt;
  const Faces faces(mesh);
  std::vector<Eigen::AlignedBox3f> boxes;
  boxes.reserve(mesh.faces.size());
  for (const Face& face : mesh.faces) {
    if (faces.HasNoArea(face)) return true;
    Eigen::AlignedBox3f box;
    for (const std::uint32_t v : face) box.extend(mesh.vertices[v]);
    boxes.push_back(box);
  }
  return MeetingBoxes(std::move(boxes)).Any([&](std::uint32_t a, std::uint32_t b) {
    return faces.Meet(a, b);
  });
}

}  // namespace deepslam::mesh
