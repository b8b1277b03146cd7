#include "deepslam/fuse/fewer_faces.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace deepslam::fuse {
namespace {

// A wave over the unit square, its colours by place.
TriangleMesh Wave(std::uint32_t side) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i <= side; ++i) {
    for (std::uint32_t j = 0; j <= side; ++j) {
      const float x = static_cast<float>(i) / static_cast<float>(side);
      const float y = static_cast<float>(j) / static_cast<float>(side);
      mesh.vertices.emplace_back(x, y, 0.1F * std::sin(6 * x));
      mesh.colours.push_back(
          {static_cast<std::uint8_t>(255 * x), static_cast<std::uint8_t>(255 * y), 7});
    }
  }
  for (std::uint32_t i = 0; i < side; ++i) {
    for (std::uint32_t j = 0; j < side; ++j) {
      const std::uint32_t n = i * (side + 1) + j;
      mesh.faces.push_back({n, n + side + 1, n + 1});
      mesh.faces.push_back({n + 1, n + side + 1, n + side + 2});
    }
  }
  return mesh;
}

double Area(const TriangleMesh& mesh) {
  double area = 0;
  for (const auto& face : mesh.faces) {
    const Eigen::Vector3f& a = mesh.vertices[face[0]];
    area += 0.5 * static_cast<double>(
                      (mesh.vertices[face[1]] - a).cross(mesh.vertices[face[2]] - a).norm());
  }
  return area;
}

TEST(WithFewerFaces, KeepsTheSurfaceAndTheColoursOfItsVertices) {
  const TriangleMesh wave = Wave(100);
  const TriangleMesh fewer = WithFewerFaces(wave, 2000);
  EXPECT_LE(fewer.faces.size(), 2000U);
  EXPECT_GT(fewer.faces.size(), 1500U);
  EXPECT_NEAR(Area(fewer), Area(wave), 0.01 * Area(wave));
  EXPECT_EQ(fewer.vertices, wave.vertices);
  EXPECT_EQ(fewer.colours, wave.colours);
  EXPECT_EQ(fewer.faces, WithFewerFaces(wave, 2000).faces);
}

TEST(WithFewerFaces, SmallMeshesStayAsTheyAre) {
  const TriangleMesh wave = Wave(10);
  EXPECT_EQ(WithFewerFaces(wave, 200).faces, wave.faces);
  EXPECT_TRUE(WithFewerFaces(TriangleMesh(), 10).faces.empty());
}

TEST(WithFewerFaces, NoLargerThanWantedEvenWhereTopologyForbidsIt) {
  TriangleMesh shards;  // edges of single triangles are borders
  for (std::uint32_t n = 0; n < 900; ++n) {
    const Eigen::Vector3f p(static_cast<float>(n % 30), static_cast<float>(n / 30), 0);
    for (const Eigen::Vector3f& corner :
         {Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(0.4F, 0, 0), Eigen::Vector3f(0, 0.4F, 0.4F)})
      shards.vertices.push_back(p + corner);
    shards.faces.push_back({3 * n, 3 * n + 1, 3 * n + 2});
  }
  const TriangleMesh fewer = WithFewerFaces(shards, 100);
  EXPECT_LE(fewer.faces.size(), 100U);
  for (const auto& face : fewer.faces)
    EXPECT_LT(*std::max_element(face.begin(), face.end()), shards.vertices.size());
}

}  // namespace
}  // namespace deepslam::fuse
