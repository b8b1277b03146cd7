#include "deepslam/furniture/solids.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

#include "deepslam/core/check.h"

namespace deepslam::furniture {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;  // rad, a full one

Eigen::Vector3d Middle(const Solids::Ring& ring) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& corner : ring) sum += corner;
  return sum / static_cast<double>(ring.size());
}

double SignedPower(double x, double exponent) {
  return std::copysign(std::pow(std::abs(x), exponent), x);
}

double VolumeTimesSix(const TriangleMesh& mesh, std::size_t first_face) {
  double sum = 0;
  for (std::size_t f = first_face; f < mesh.faces.size(); ++f) {
    const auto& face = mesh.faces[f];
    const Eigen::Vector3d a = mesh.vertices[face[0]].cast<double>();
    const Eigen::Vector3d b = mesh.vertices[face[1]].cast<double>();
    const Eigen::Vector3d c = mesh.vertices[face[2]].cast<double>();
    sum += a.dot(b.cross(c));
  }
  return sum;
}

Solids::Ring Rectangle(const Eigen::Vector3d& middle, const Eigen::Vector2d& size) {
  Solids::Ring ring;
  for (const auto& [x, y] : {std::pair(-0.5, -0.5), {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}) {
    ring.emplace_back(middle + Eigen::Vector3d(x * size.x(), y * size.y(), 0));
  }
  return ring;
}

Eigen::Vector2d Superellipse(double angle_rad, const Eigen::Vector2d& size, double roundness) {
  return {0.5 * size.x() * SignedPower(std::cos(angle_rad), roundness),
          0.5 * size.y() * SignedPower(std::sin(angle_rad), roundness)};
}

}  // namespace

Bend Leaning(double lean) {
  return [lean](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(p.x() - lean * p.z(), p.y(), p.z());
  };
}

void Solids::Loft(Material material, const std::vector<Ring>& rings) {
  DEEPSLAM_CHECK(rings.size() >= 2 && rings.front().size() >= 3, "a solid needs two rings");
  const auto sides = static_cast<std::uint32_t>(rings.front().size());
  const auto count = static_cast<std::uint32_t>(rings.size());
  const auto base = static_cast<std::uint32_t>(mesh_.vertices.size());
  const std::size_t first_face = mesh_.faces.size();
  first_faces_.push_back(static_cast<std::uint32_t>(first_face));
  for (const Ring& ring : rings) {
    DEEPSLAM_CHECK(ring.size() == sides, "rings of one solid have equally many corners");
    for (const Eigen::Vector3d& corner : ring) mesh_.vertices.push_back(corner.cast<float>());
  }
  const std::uint32_t low = base + count * sides;
  mesh_.vertices.push_back(Middle(rings.front()).cast<float>());
  mesh_.vertices.push_back(Middle(rings.back()).cast<float>());
  for (std::uint32_t s = 0; s < sides; ++s) {
    const std::uint32_t next = (s + 1) % sides;
    mesh_.faces.push_back({low, base + next, base + s});
    for (std::uint32_t r = 0; r + 1 < count; ++r) {
      const std::uint32_t a = base + r * sides + s;
      const std::uint32_t b = base + r * sides + next;
      mesh_.faces.push_back({a, b, b + sides});
      mesh_.faces.push_back({a, b + sides, a + sides});
    }
    const std::uint32_t last = base + (count - 1) * sides;
    mesh_.faces.push_back({low + 1, last + s, last + next});
  }
  if (VolumeTimesSix(mesh_, first_face) < 0) {
    for (std::size_t f = first_face; f < mesh_.faces.size(); ++f)
      std::swap(mesh_.faces[f][1], mesh_.faces[f][2]);
  }
  materials_.resize(mesh_.faces.size(), static_cast<std::uint8_t>(material));
}

void Solids::Frustum(Material material,
                     const Eigen::Vector3d& low,
                     const Eigen::Vector2d& low_size,
                     const Eigen::Vector3d& high,
                     const Eigen::Vector2d& high_size) {
  Loft(material, {Rectangle(low, low_size), Rectangle(high, high_size)});
}

void Solids::Box(Material material, const Eigen::Vector3d& middle, const Eigen::Vector3d& size) {
  const Eigen::Vector3d half(0, 0, 0.5 * size.z());
  Frustum(material, middle - half, size.head<2>(), middle + half, size.head<2>());
}

void Solids::Tube(Material material,
                  const std::vector<Eigen::Vector3d>& line,
                  double first_radius,
                  double last_radius,
                  int sides) {
  std::vector<Ring> rings;
  Eigen::Vector3d across = Eigen::Vector3d::Zero();
  for (std::size_t n = 0; n < line.size(); ++n) {
    const Eigen::Vector3d along =
        (line[std::min(n + 1, line.size() - 1)] - line[n == 0 ? 0 : n - 1]).normalized();
    // Carried along the line, so that the bar does not twist.
    if (n == 0) across = along.unitOrthogonal();
    across = (across - along * along.dot(across)).normalized();
    const Eigen::Vector3d third = along.cross(across);
    const double t =
        line.size() > 1 ? static_cast<double>(n) / static_cast<double>(line.size() - 1) : 0;
    const double radius = first_radius + t * (last_radius - first_radius);
    Ring ring;
    for (int s = 0; s < sides; ++s) {
      const double angle = kTurn * s / sides;
      ring.emplace_back(line[n] + radius * (std::cos(angle) * across + std::sin(angle) * third));
    }
    rings.push_back(std::move(ring));
  }
  Loft(material, rings);
}

void Solids::Turned(Material material,
                    const Eigen::Vector3d& foot,
                    const std::vector<Eigen::Vector2d>& radius_height,
                    int sides) {
  std::vector<Ring> rings;
  for (const Eigen::Vector2d& at : radius_height) {
    Ring ring;
    for (int s = 0; s < sides; ++s) {
      const double angle = kTurn * s / sides;
      ring.emplace_back(
          foot + Eigen::Vector3d(at.x() * std::cos(angle), at.x() * std::sin(angle), at.y()));
    }
    rings.push_back(std::move(ring));
  }
  Loft(material, rings);
}

void Solids::Cushion(Material material,
                     const Eigen::Vector3d& middle,
                     const Eigen::Vector3d& size,
                     double side_roundness,
                     double top_roundness,
                     const Bend& bend) {
  constexpr int kCushionRings = 9;   // latitudes: a cushion is few voxels high, more would not show
  constexpr int kCushionSides = 20;  // corners round a cushion
  std::vector<Ring> rings;
  for (int r = 0; r < kCushionRings; ++r) {
    // The fans at both ends close the caps that are left out.
    const double latitude =
        std::numbers::pi * (static_cast<double>(r + 1) / (kCushionRings + 1) - 0.5);
    const double width = SignedPower(std::cos(latitude), side_roundness);
    Ring ring;
    for (int s = 0; s < kCushionSides; ++s) {
      const Eigen::Vector2d p =
          Superellipse(kTurn * (s + 0.5) / kCushionSides, size.head<2>(), top_roundness);
      Eigen::Vector3d corner(width * p.x(),
                             width * p.y(),
                             0.5 * size.z() * SignedPower(std::sin(latitude), side_roundness));
      ring.push_back(middle + (bend ? bend(corner) : corner));
    }
    rings.push_back(std::move(ring));
  }
  Loft(material, rings);
}

void Solids::Plate(Material material,
                   const Eigen::Vector3d& middle,
                   const Eigen::Vector3d& size,
                   double roundness) {
  constexpr int kPlateSides = 32;  // corners round a plate, whose rim is seen more sharply
  std::vector<Ring> rings(2);
  for (int s = 0; s < kPlateSides; ++s) {
    const Eigen::Vector2d p =
        Superellipse(kTurn * (s + 0.5) / kPlateSides, size.head<2>(), roundness);
    rings[0].emplace_back(middle + Eigen::Vector3d(p.x(), p.y(), -0.5 * size.z()));
    rings[1].emplace_back(middle + Eigen::Vector3d(p.x(), p.y(), 0.5 * size.z()));
  }
  Loft(material, rings);
}

void Solids::Board(Material material,
                   const std::function<Eigen::Vector3d(double, double)>& place,
                   double thickness,
                   int columns,
                   int rows) {
  const Eigen::Vector3d half(0.5 * thickness, 0, 0);
  std::vector<Ring> rings;
  for (int c = 0; c < columns; ++c) {
    const double u = 2.0 * c / (columns - 1) - 1.0;
    Ring ring;
    for (int r = 0; r < rows; ++r)
      ring.push_back(place(u, static_cast<double>(r) / (rows - 1)) + half);
    for (int r = rows - 1; r >= 0; --r)
      ring.push_back(place(u, static_cast<double>(r) / (rows - 1)) - half);
    rings.push_back(std::move(ring));
  }
  Loft(material, rings);
}

}  // namespace deepslam::furniture
