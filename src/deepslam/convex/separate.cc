#include "deepslam/convex/separate.h"

#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include "deepslam/convex/convex_hull.h"
#include "deepslam/geometry/box.h"

namespace deepslam::convex {
namespace {

Box3 BoxOf(const TriangleMesh& mesh) {
  Box3 box;
  for (const Eigen::Vector3f& p : mesh.vertices) box.Extend(p.cast<double>());
  return box;
}

Box3 BoxOf(const PiecedThing& thing) {
  Box3 box;
  for (const TriangleMesh& piece : thing.pieces) {
    for (const Eigen::Vector3f& p : piece.vertices) box.Extend(p.cast<double>());
  }
  return box;
}

bool Touch(const Box3& a, const Box3& b) {
  return !a.empty() && !b.empty() && (a.min.array() < b.max.array()).all() &&
         (b.min.array() < a.max.array()).all();
}

// Along `normal` the first ends at `first_end`, and the second begins at `second_begin` below it.
struct Overlap {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitX();
  double first_end = 0;
  double second_begin = 0;
  [[nodiscard]] double depth() const { return first_end - second_begin; }
};

Overlap Along(const Eigen::Vector3d& normal,
              const TriangleMesh& first,
              const TriangleMesh& second) {
  Overlap overlap{
      normal, -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  for (const Eigen::Vector3f& p : first.vertices)
    overlap.first_end = std::max(overlap.first_end, normal.dot(p.cast<double>()));
  for (const Eigen::Vector3f& p : second.vertices)
    overlap.second_begin = std::min(overlap.second_begin, normal.dot(p.cast<double>()));
  return overlap;
}

// The least deep along the normals of both: cuts there take the least away. Nothing where a plane
// along a face has them on two sides.
std::optional<Overlap> LeastOverlap(const TriangleMesh& first, const TriangleMesh& second) {
  std::optional<Overlap> least;
  for (const bool of_first : {true, false}) {
    const TriangleMesh& mesh = of_first ? first : second;
    for (const auto& face : mesh.faces) {
      const Eigen::Vector3d a = mesh.vertices[face[0]].cast<double>();
      const Eigen::Vector3d across = (mesh.vertices[face[1]].cast<double>() - a)
                                         .cross(mesh.vertices[face[2]].cast<double>() - a);
      if (!(across.norm() > 0)) continue;
      const Eigen::Vector3d normal = across.normalized() * (of_first ? 1 : -1);
      const Overlap overlap = Along(normal, first, second);
      if (overlap.depth() <= 0) return std::nullopt;
      if (!least || overlap.depth() < least->depth()) least = overlap;
    }
  }
  return least;
}

void CutApart(PiecedThing& one, std::size_t a, PiecedThing& other, std::size_t b, double gap_m) {
  if (!Touch(BoxOf(one.pieces[a]), BoxOf(other.pieces[b]))) return;
  const std::optional<Overlap> overlap = LeastOverlap(one.pieces[a], other.pieces[b]);
  if (!overlap) return;
  double first_end = 0.5 * (overlap->first_end + overlap->second_begin - gap_m);
  if (other.fixed) first_end = overlap->second_begin - gap_m;
  if (one.fixed) first_end = overlap->first_end;
  if (!one.fixed) one.pieces[a] = ClipConvex(one.pieces[a], overlap->normal, first_end);
  if (!other.fixed)
    other.pieces[b] = ClipConvex(other.pieces[b], -overlap->normal, -(first_end + gap_m));
}

}  // namespace

void Separate(std::vector<PiecedThing>& things, double gap_m) {
  std::vector<Box3> boxes;  // before any cut: things only become smaller
  for (const PiecedThing& thing : things) boxes.push_back(BoxOf(thing));
  for (std::size_t n = 0; n < things.size(); ++n) {
    for (std::size_t m = n + 1; m < things.size(); ++m) {
      if ((things[n].fixed && things[m].fixed) || !Touch(boxes[n], boxes[m])) continue;
      for (std::size_t a = 0; a < things[n].pieces.size(); ++a) {
        for (std::size_t b = 0; b < things[m].pieces.size(); ++b)
          CutApart(things[n], a, things[m], b, gap_m);
      }
    }
  }
  for (PiecedThing& thing : things)
    std::erase_if(thing.pieces, [](const TriangleMesh& piece) { return piece.empty(); });
}

}  // namespace deepslam::convex
