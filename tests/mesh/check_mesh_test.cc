#include "deepslam/mesh/check_mesh.h"

#include <limits>

#include <gtest/gtest.h>

#include "support/box_meshes.h"

namespace deepslam::mesh {
namespace {

using testing_support::Tetrahedron;

// Appends `other`, moved.
TriangleMesh Joined(TriangleMesh mesh, const TriangleMesh& other, const Eigen::Vector3f& offset) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const Eigen::Vector3f& p : other.vertices) mesh.vertices.push_back(p + offset);
  for (const auto& f : other.faces)
    mesh.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
  return mesh;
}

TEST(CheckMesh, AcceptsATetrahedronAndMeasuresIt) {
  const MeshCheck check = CheckMesh(Tetrahedron());
  EXPECT_TRUE(check.ok()) << check.fault;
  EXPECT_NEAR(check.volume_m3, 1.0 / 6.0, 1e-6);
  EXPECT_EQ(check.num_components, 1);
}

TEST(CheckMesh, WeldsVerticesAtOnePlace) {
  TriangleMesh soup;
  const TriangleMesh mesh = Tetrahedron();
  for (const auto& face : mesh.faces) {
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    for (const auto v : face) soup.vertices.push_back(mesh.vertices[v]);
    soup.faces.push_back({first, first + 1, first + 2});
  }
  EXPECT_TRUE(CheckMesh(soup).ok());
}

TEST(CheckMesh, FindsHolesAndFlippedAndInsideOutFaces) {
  TriangleMesh hole = Tetrahedron();
  hole.faces.pop_back();
  EXPECT_FALSE(CheckMesh(hole).closed);
  TriangleMesh flipped = Tetrahedron();
  std::swap(flipped.faces[1][0], flipped.faces[1][1]);
  EXPECT_FALSE(CheckMesh(flipped).oriented);
  TriangleMesh inside_out = Tetrahedron();
  for (auto& face : inside_out.faces) std::swap(face[0], face[1]);
  EXPECT_FALSE(CheckMesh(inside_out).oriented);
  EXPECT_FALSE(CheckMesh(inside_out).fault.empty());
}

TEST(CheckMesh, FindsTwoSolidsThatShareACornerOnly) {
  TriangleMesh mirrored = Tetrahedron();
  for (Eigen::Vector3f& p : mirrored.vertices) p = -p;
  for (auto& face : mirrored.faces) std::swap(face[0], face[1]);
  const MeshCheck check = CheckMesh(Joined(Tetrahedron(), mirrored, {0, 0, 0}));
  EXPECT_TRUE(check.closed);
  EXPECT_FALSE(check.two_manifold);
}

TEST(CheckMesh, FindsThreeFacesAtAnEdge) {
  TriangleMesh mesh = Tetrahedron();
  mesh.vertices.emplace_back(2.0F, 2.0F, 2.0F);
  mesh.faces.push_back({0, 1, 4});
  EXPECT_FALSE(CheckMesh(mesh).closed);
}

TEST(CheckMesh, RefusesBadIndicesAndNumbers) {
  TriangleMesh index = Tetrahedron();
  index.faces[0][0] = 99;
  EXPECT_FALSE(CheckMesh(index).valid);
  TriangleMesh nan = Tetrahedron();
  nan.vertices[0].x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(CheckMesh(nan).valid);
  TriangleMesh needle = Tetrahedron();
  needle.faces[0] = {0, 0, 1};
  EXPECT_FALSE(CheckMesh(needle).valid);
  EXPECT_FALSE(CheckMesh(TriangleMesh()).valid);
}

TEST(SelfIntersects, SeesSolidsThatCross) {
  EXPECT_FALSE(SelfIntersects(Tetrahedron()));
  EXPECT_FALSE(SelfIntersects(Joined(Tetrahedron(), Tetrahedron(), {3, 0, 0})));
  EXPECT_TRUE(SelfIntersects(Joined(Tetrahedron(), Tetrahedron(), {0.2F, 0.1F, 0.1F})));
}

}  // namespace
}  // namespace deepslam::mesh
