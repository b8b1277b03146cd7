#include "deepslam/gltf/draco_mesh.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include <draco/compression/encode.h>
#include <draco/core/encoder_buffer.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gtest/gtest.h>

#include "deepslam/core/random.h"
#include "deepslam/scene/mesh_check.h"
#include "gltf/test_scene.h"

namespace deepslam::gltf {
namespace {

// A closed torus of n x n quads, coloured.
TriangleMesh Torus(int n) {
  TriangleMesh mesh;
  const auto id = [n](int i, int j) { return static_cast<std::uint32_t>((i % n) * n + j % n); };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const double a = 6.283185307179586 * i / n;
      const double b = 6.283185307179586 * j / n;
      const double r = 1.0 + 0.4 * std::cos(b);
      mesh.vertices.push_back(
          Eigen::Vector3d(r * std::cos(a), r * std::sin(a), 0.4 * std::sin(b)).cast<float>());
      mesh.colours.push_back({static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(j), 7});
      mesh.faces.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      mesh.faces.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  }
  return mesh;
}

TEST(DracoMesh, RoundTripStaysClosedWithinTheStatedError) {
  const TriangleMesh mesh = Torus(40);
  ASSERT_TRUE(CheckMesh(mesh).ok());
  for (const int bits : {10, 12, 14, 18}) {
    const Result<std::string> bytes = DracoEncode(mesh, bits);
    ASSERT_TRUE(bytes.ok());
    const Result<TriangleMesh> decoded = DracoDecode(*bytes);
    ASSERT_TRUE(decoded.ok());
    const MeshCheck check = CheckMesh(*decoded);
    EXPECT_TRUE(check.ok()) << check.fault;
    ASSERT_EQ(decoded->vertices.size(), mesh.vertices.size());
    ASSERT_EQ(decoded->faces.size(), mesh.faces.size());
    // Colours are unique and lossless: they tell which vertex is which.
    for (std::size_t n = 0; n < decoded->vertices.size(); ++n) {
      const Rgb8 c = decoded->colours[n];
      const Eigen::Vector3f& source = mesh.vertices[static_cast<std::size_t>(c.r) * 40 + c.g];
      const double off = static_cast<double>((decoded->vertices[n] - source).cwiseAbs().maxCoeff());
      EXPECT_LE(off, QuantisationError(mesh, bits));
    }
  }
  EXPECT_LT(QuantisationError(mesh, 14), 2e-4);
}

TEST(DracoMesh, RefinesTheGridWhereVerticesWouldFallTogether) {
  TriangleMesh mesh = BoxMesh(1, 1, 1);
  const TriangleMesh tiny = BoxMesh(0.0005F, 0.0005F, 0.001F);
  for (const auto& f : tiny.faces) mesh.faces.push_back({f[0] + 8, f[1] + 8, f[2] + 8});
  for (const auto& p : tiny.vertices) mesh.vertices.push_back(p + Eigen::Vector3f(5, 5, 5));
  const Result<std::string> bytes = DracoEncode(mesh, 8);
  ASSERT_TRUE(bytes.ok());
  EXPECT_TRUE(CheckMesh(*DracoDecode(*bytes)).ok());
}

TEST(DracoMesh, RefusesWhatCannotBeEncoded) {
  EXPECT_FALSE(DracoEncode(TriangleMesh(), 14).ok());
  TriangleMesh index = BoxMesh(1, 1, 1);
  index.faces[0][0] = 100;
  EXPECT_FALSE(DracoEncode(index, 14).ok());
  TriangleMesh nan = BoxMesh(1, 1, 1);
  nan.vertices[0].x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(DracoEncode(nan, 14).ok());
  EXPECT_FALSE(DracoEncode(BoxMesh(1, 1, 1), 99).ok());
}

TEST(DracoMesh, DecodesNothingOutOfDamagedBytesButNeverDies) {
  const std::string bytes = *DracoEncode(Torus(12), 12);
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    EXPECT_FALSE(DracoDecode(std::string_view(bytes).substr(0, n)).ok()) << n;
  }
  Random random(3);
  for (int n = 0; n < 2000; ++n) {
    std::string damaged = bytes;
    for (int flips = 0; flips < 3; ++flips) {
      damaged[random.Index(damaged.size())] = static_cast<char>(random.Next());
    }
    const Result<TriangleMesh> decoded = DracoDecode(damaged);
    if (!decoded) continue;
    for (const auto& face : decoded->faces) {
      for (const auto v : face) ASSERT_LT(v, decoded->vertices.size());
    }
  }
  EXPECT_FALSE(DracoDecode("").ok());
  EXPECT_FALSE(DracoDecode("DRACO").ok());
}

// One triangle whose corners are (1, 1, 1), (1, 0, 1) and (0, 0, 1), of whatever type.
template <typename Number>
std::string TriangleOf(draco::DataType type) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(1);
  const int id = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, type);
  const std::array<std::array<Number, 3>, 3> corners = {{{1, 1, 1}, {1, 0, 1}, {0, 0, 1}}};
  builder.SetAttributeValuesForFace(
      id, draco::FaceIndex(0), corners[0].data(), corners[1].data(), corners[2].data());
  draco::EncoderBuffer buffer;
  draco::Encoder encoder;
  encoder.SetEncodingMethod(draco::MESH_SEQUENTIAL_ENCODING);
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*builder.Finalize(), &buffer).ok());
  return {buffer.data(), buffer.size()};
}

// Furniture may hold numbers of any type, but no truth values: their bytes may be neither of the
// two.
TEST(DracoMesh, RefusesTruthValuesAsPositions) {
  const DracoAttributeIds ids = {.position = 0, .place = -1, .colour = -1};
  const auto floats = DracoDecodeModel(TriangleOf<float>(draco::DT_FLOAT32), ids);
  ASSERT_TRUE(floats.ok()) << floats.error().message;
  EXPECT_EQ(floats->positions.size(), 3U);
  EXPECT_TRUE(DracoDecodeModel(TriangleOf<double>(draco::DT_FLOAT64), ids).ok());
  EXPECT_FALSE(DracoDecodeModel(TriangleOf<bool>(draco::DT_BOOL), ids).ok());
}

}  // namespace
}  // namespace deepslam::gltf
