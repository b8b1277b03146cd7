// Meshes of a tetrahedron, boxes, balls and furniture made of boxes, for tests.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::testing_support {

inline TriangleMesh Tetrahedron() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.faces = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

inline void AddBox(const Eigen::Vector3f& low, const Eigen::Vector3f& high, TriangleMesh& mesh) {
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int n = 0; n < 8; ++n) {
    mesh.vertices.emplace_back((n & 4) != 0 ? high.x() : low.x(),
                               (n & 2) != 0 ? high.y() : low.y(),
                               (n & 1) != 0 ? high.z() : low.z());
  }
  constexpr std::array<std::array<std::uint32_t, 4>, 6> kSides = {
      {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}}};
  for (const auto& side : kSides) {
    mesh.faces.push_back({base + side[0], base + side[1], base + side[2]});
    mesh.faces.push_back({base + side[0], base + side[2], base + side[3]});
  }
}

inline TriangleMesh BoxMesh(const Eigen::Vector3f& size) {
  TriangleMesh mesh;
  AddBox(-0.5F * size, 0.5F * size, mesh);
  return mesh;
}

inline TriangleMesh SphereMesh(float radius) {
  constexpr int kRings = 48;
  TriangleMesh mesh;
  for (int a = 0; a <= kRings; ++a) {
    for (int b = 0; b < 2 * kRings; ++b) {
      const float theta = std::numbers::pi_v<float> * static_cast<float>(a) / kRings;
      const float phi = std::numbers::pi_v<float> * static_cast<float>(b) / kRings;
      mesh.vertices.emplace_back(radius * std::sin(theta) * std::cos(phi),
                                 radius * std::sin(theta) * std::sin(phi),
                                 radius * std::cos(theta));
    }
  }
  for (std::uint32_t a = 0; a < kRings; ++a) {
    for (std::uint32_t b = 0; b < 2 * kRings; ++b) {
      const std::uint32_t next = (b + 1) % (2 * kRings);
      const std::uint32_t row = a * 2 * kRings;
      const std::uint32_t below = row + 2 * kRings;
      mesh.faces.push_back({row + b, below + b, below + next});
      mesh.faces.push_back({row + b, below + next, row + next});
    }
  }
  return mesh;
}

// Four-legged chair on z = 0, front +x; sizes in metres.
inline TriangleMesh ChairMesh(
    float width, float depth, float seat_height, float height, float leg) {
  TriangleMesh mesh;
  const float x = 0.5F * depth;
  const float y = 0.5F * width;
  for (const float sx : {-1.0F, 1.0F}) {
    for (const float sy : {-1.0F, 1.0F}) {
      const Eigen::Vector3f foot(sx * (x - 0.5F * leg), sy * (y - 0.5F * leg), 0);
      AddBox(foot - Eigen::Vector3f(0.5F * leg, 0.5F * leg, 0),
             foot + Eigen::Vector3f(0.5F * leg, 0.5F * leg, seat_height),
             mesh);
    }
  }
  AddBox({-x, -y, seat_height - 0.05F}, {x, y, seat_height}, mesh);
  AddBox({-x, -y, seat_height}, {-x + 0.05F, y, height}, mesh);
  return mesh;
}

// Four-legged table on z = 0, length along y.
inline TriangleMesh TableMesh(float length, float width, float height, float leg) {
  TriangleMesh mesh;
  const float x = 0.5F * width;
  const float y = 0.5F * length;
  for (const float sx : {-1.0F, 1.0F}) {
    for (const float sy : {-1.0F, 1.0F}) {
      const Eigen::Vector3f foot(sx * (x - 0.5F * leg), sy * (y - 0.5F * leg), 0);
      AddBox(foot - Eigen::Vector3f(0.5F * leg, 0.5F * leg, 0),
             foot + Eigen::Vector3f(0.5F * leg, 0.5F * leg, height),
             mesh);
    }
  }
  AddBox({-x, -y, height - 0.05F}, {x, y, height}, mesh);
  return mesh;
}

}  // namespace deepslam::testing_support
