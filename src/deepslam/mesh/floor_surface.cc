#include "deepslam/mesh/floor_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "deepslam/core/parallel.h"
#include "deepslam/mesh/colour_raster.h"
#include "deepslam/mesh/ground_polygon.h"
#include "deepslam/mesh/surface_distance.h"
#include "deepslam/scene/mesh_pieces.h"

namespace deepslam::mesh {
namespace {

constexpr double kMaxColourPoints = 40'000;       // bounds the floor's vertices: 25 m^2 at 2.5 cm
constexpr std::size_t kMaxColourCells = 400'000;  // of the outline's box, mostly not much larger
// Cosine of the steepest face that is floor: noise tilts faces of a few centimetres a good deal.
constexpr double kMinLevel = 0.6;

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

class Outline {
 public:
  explicit Outline(std::vector<Eigen::Vector2d> points) : points_(std::move(points)) {}

  [[nodiscard]] bool empty() const { return points_.size() < 3; }
  [[nodiscard]] const std::vector<Eigen::Vector2d>& points() const { return points_; }

  [[nodiscard]] bool Contains(const Eigen::Vector2d& p) const {
    bool inside = false;
    ForEdges([&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
      if ((a.y() > p.y()) == (b.y() > p.y())) return;
      const double x = a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
      if (p.x() < x) inside = !inside;
    });
    return inside;
  }
  [[nodiscard]] bool Crosses(const Eigen::Vector2d& p, const Eigen::Vector2d& q) const {
    bool crosses = false;
    ForEdges([&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
      const bool parted = Cross(b - a, p - a) * Cross(b - a, q - a) < 0;
      crosses = crosses || (parted && Cross(q - p, a - p) * Cross(q - p, b - p) < 0);
    });
    return crosses;
  }
  [[nodiscard]] double DistanceTo(const Eigen::Vector2d& p) const {
    double squared = 1e300;
    ForEdges([&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
      const Eigen::Vector2d along = b - a;
      const double t = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
      squared = std::min(squared, (p - a - t * along).squaredNorm());
    });
    return std::sqrt(squared);
  }
  [[nodiscard]] Eigen::AlignedBox2d Box() const {
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector2d& p : points_) box.extend(p);
    return box;
  }
  [[nodiscard]] double Area() const {
    double twice = 0;
    ForEdges([&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { twice += Cross(a, b); });
    return 0.5 * twice;
  }

 private:
  template <typename Visitor>
  void ForEdges(const Visitor& visit) const {
    for (std::size_t n = 0; n < points_.size(); ++n)
      visit(points_[n], points_[(n + 1) % points_.size()]);
  }

  std::vector<Eigen::Vector2d> points_;
};

Eigen::Vector2d Plan(const Eigen::Vector3f& p) { return p.head<2>().cast<double>(); }

enum class Place : std::uint8_t { kOff, kBeside, kOver };  // off the floor's plane; in it

std::vector<Place> PlacesOf(const TriangleMesh& room, const Outline& outline, double band_m) {
  std::vector<Place> places(room.vertices.size(), Place::kOff);
  for (std::size_t v = 0; v < places.size(); ++v) {
    if (std::abs(room.vertices[v].z()) >= band_m) continue;
    places[v] = outline.Contains(Plan(room.vertices[v])) ? Place::kOver : Place::kBeside;
  }
  return places;
}

// Of faces whose corners all lie in the band.
bool IsLevel(const TriangleMesh& room, const std::array<std::uint32_t, 3>& face) {
  const Eigen::Vector3f& a = room.vertices[face[0]];
  const Eigen::Vector3f normal = (room.vertices[face[1]] - a).cross(room.vertices[face[2]] - a);
  return std::abs(normal.z()) >= kMinLevel * static_cast<double>(normal.norm());
}

// Pieces of the mesh that lie in the band as a whole, and mostly over the polygon.
void DropRags(const std::vector<Place>& places, TriangleMesh& room) {
  const std::vector<std::uint32_t> piece = PieceOfVertex(room.faces, room.vertices.size());
  std::vector<std::array<int, 3>> counts(room.vertices.size(), {0, 0, 0});
  for (const auto& face : room.faces) {
    for (const std::uint32_t v : face) ++counts[piece[v]][static_cast<std::size_t>(places[v])];
  }
  std::erase_if(room.faces, [&](const auto& face) {
    const auto& [off, beside, over] = counts[piece[face[0]]];
    return off == 0 && over > beside;
  });
}

std::vector<Eigen::Vector2d> PointsInside(const Outline& outline, double step_m) {
  Eigen::Vector2d low = outline.points().front();
  Eigen::Vector2d high = low;
  for (const Eigen::Vector2d& p : outline.points()) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  std::vector<Eigen::Vector2d> inside;
  for (double x = std::ceil(low.x() / step_m) * step_m; x < high.x(); x += step_m) {
    for (double y = std::ceil(low.y() / step_m) * step_m; y < high.y(); y += step_m) {
      const Eigen::Vector2d p(x, y);
      if (outline.Contains(p) && outline.DistanceTo(p) > 0.4 * step_m) inside.push_back(p);
    }
  }
  return inside;
}

// Which of the points lie within a distance of an object's surface; 0 or 1.
std::vector<std::uint8_t> NearObjects(const std::vector<Eigen::Vector3f>& points,
                                      std::span<const TriangleMesh> objects,
                                      double distance_m) {
  const auto margin = static_cast<float>(distance_m);
  std::vector<std::vector<std::size_t>> by_object(objects.size());
  ParallelFor(objects.size(), [&](std::size_t k) {
    if (objects[k].faces.empty()) return;
    Eigen::AlignedBox3f box;
    for (const Eigen::Vector3f& p : objects[k].vertices) box.extend(p);
    const Eigen::AlignedBox3f reach(box.min().array() - margin, box.max().array() + margin);
    std::vector<std::size_t> which;
    std::vector<Eigen::Vector3f> in_reach;
    for (std::size_t v = 0; v < points.size(); ++v) {
      if (!reach.contains(points[v])) continue;
      which.push_back(v);
      in_reach.push_back(points[v]);
    }
    const std::vector<std::uint8_t> found = AreNear(in_reach, objects[k], distance_m);
    for (std::size_t n = 0; n < which.size(); ++n) {
      if (found[n] != 0) by_object[k].push_back(which[n]);
    }
  });
  std::vector<std::uint8_t> near(points.size(), 0);
  for (const std::vector<std::size_t>& of_object : by_object) {
    for (const std::size_t v : of_object) near[v] = 1;
  }
  return near;
}

}  // namespace

TriangleMesh WithoutFloor(const TriangleMesh& room_world,
                          const TriangleMesh& ground_polygon,
                          double band_m) {
  TriangleMesh room = room_world;
  const Outline outline(OutlineOf(ground_polygon));
  if (outline.empty()) return room;
  const std::vector<Place> places = PlacesOf(room, outline, band_m);
  std::erase_if(room.faces, [&](const std::array<std::uint32_t, 3>& face) {
    bool over = false;
    for (const std::uint32_t v : face) {
      if (places[v] == Place::kOff) return false;
      over = over || places[v] == Place::kOver;
    }
    for (std::size_t n = 0; n < 3 && !over; ++n)
      over = outline.Crosses(Plan(room.vertices[face[n]]), Plan(room.vertices[face[(n + 1) % 3]]));
    return over && IsLevel(room, face);
  });
  DropRags(places, room);
  return room;
}

TriangleMesh WithoutObjects(const TriangleMesh& room_world,
                            std::span<const TriangleMesh> objects_world,
                            double distance_m,
                            double floor_band_m) {
  const std::vector<std::uint8_t> near =
      NearObjects(room_world.vertices, objects_world, distance_m);
  const auto on_floor = [&](std::uint32_t v) {
    return std::abs(room_world.vertices[v].z()) < floor_band_m;
  };
  TriangleMesh room = room_world;
  std::erase_if(room.faces, [&](const std::array<std::uint32_t, 3>& face) {
    const bool floor = std::all_of(face.begin(), face.end(), on_floor) && IsLevel(room_world, face);
    return !floor && near[face[0]] != 0 && near[face[1]] != 0 && near[face[2]] != 0;
  });
  return room;
}

TriangleMesh ColouredGround(const TriangleMesh& ground_polygon,
                            const TriangleMesh& room_world,
                            double band_m,
                            double step_m) {
  const Outline outline(OutlineOf(ground_polygon));
  if (outline.empty() || step_m <= 0 || room_world.colours.empty()) return ground_polygon;
  step_m = std::max(step_m, std::sqrt(outline.Area() / kMaxColourPoints));
  ColourRaster raster(outline.Box(), step_m, kMaxColourCells);
  for (std::size_t v = 0; v < room_world.vertices.size(); ++v) {
    const Eigen::Vector3f& p = room_world.vertices[v];
    if (std::abs(p.z()) < band_m) raster.Add(Plan(p), room_world.colours[v]);
  }
  if (raster.empty()) return ground_polygon;
  Result<TriangleMesh> ground = TriangulateOutline(outline.points(), PointsInside(outline, step_m));
  if (!ground.ok()) return ground_polygon;
  ground->colours.reserve(ground->vertices.size());
  const Image<Rgb8> colours = raster.Filled();
  for (const Eigen::Vector3f& p : ground->vertices) {
    const Eigen::Vector2i cell = raster.CellOf(Plan(p));
    ground->colours.push_back(colours(cell.x(), cell.y()));
  }
  return std::move(ground).value();
}

}  // namespace deepslam::mesh
