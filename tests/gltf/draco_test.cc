#include "deepslam/gltf/draco_decode.h"
#include "deepslam/gltf/draco_encode.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include <draco/compression/encode.h>
#include <draco/core/encoder_buffer.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gtest/gtest.h>

#include "deepslam/core/random.h"
#include "deepslam/shape/mesh_check.h"
#include "gltf/test_scene.h"

namespace deepslam::gltf {
namespace {

// A closed torus of n x n quads, coloured.
RenderMesh Torus(std::uint32_t n) {
  RenderMesh mesh;
  const auto id = [n](std::uint32_t i, std::uint32_t j) { return (i % n) * n + j % n; };
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t j = 0; j < n; ++j) {
      const double a = 6.283185307179586 * i / n;
      const double b = 6.283185307179586 * j / n;
      const double r = 1.0 + 0.4 * std::cos(b);
      const Eigen::Vector3d out(std::cos(b) * std::cos(a), std::cos(b) * std::sin(a), std::sin(b));
      mesh.positions.push_back(
          Eigen::Vector3d(r * std::cos(a), r * std::sin(a), 0.4 * std::sin(b)).cast<float>());
      mesh.normals.push_back(out.cast<float>());
      mesh.colours.push_back(
          {static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(j), 65535, 65535});
      mesh.faces.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      mesh.faces.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  }
  return mesh;
}

TriangleMesh Surface(const RenderMesh& mesh) { return {mesh.positions, mesh.faces, {}}; }

RenderMesh Box(float x, float y, float z) { return MakeRenderMesh(BoxMesh(x, y, z), 3.2); }

TEST(Draco, RoundTripStaysClosedWithinTheStatedError) {
  constexpr std::uint32_t kSide = 40;
  const RenderMesh mesh = Torus(kSide);
  ASSERT_TRUE(shape::CheckMesh(Surface(mesh)).ok());
  for (const int bits : {10, 12, 14, 18}) {
    const Result<DracoPayload> payload = DracoEncode(mesh, bits, 8);
    ASSERT_TRUE(payload.ok()) << payload.error().message;
    const RenderMesh& decoded = payload->decoded;
    const shape::MeshCheck check = shape::CheckMesh(Surface(decoded));
    EXPECT_TRUE(check.ok()) << check.fault;
    ASSERT_EQ(decoded.positions.size(), mesh.positions.size());
    ASSERT_EQ(decoded.faces.size(), mesh.faces.size());
    ASSERT_EQ(decoded.colours.size(), mesh.positions.size());
    // Colours are unique and lossless: they tell which vertex is which.
    for (std::size_t n = 0; n < decoded.positions.size(); ++n) {
      const auto& c = decoded.colours[n];
      ASSERT_TRUE(c[0] < kSide && c[1] < kSide && c[2] == 65535);
      const std::size_t source = c[0] * kSide + c[1];
      const float off = (decoded.positions[n] - mesh.positions[source]).cwiseAbs().maxCoeff();
      EXPECT_LE(static_cast<double>(off), QuantisationError(mesh.positions, bits));
      // Eight bits of an octahedron: steps of a degree and a half at most.
      EXPECT_GT(decoded.normals[n].dot(mesh.normals[source]), 0.999F);
    }
  }
  EXPECT_LT(QuantisationError(mesh.positions, 14), 2e-4);
}

TEST(Draco, RefinesTheGridWhereVerticesWouldFallTogether) {
  TriangleMesh mesh = BoxMesh(1, 1, 1);
  const TriangleMesh tiny = BoxMesh(0.0005F, 0.0005F, 0.001F);
  for (const auto& f : tiny.faces) mesh.faces.push_back({f[0] + 8, f[1] + 8, f[2] + 8});
  for (const auto& p : tiny.vertices) mesh.vertices.push_back(p + Eigen::Vector3f(5, 5, 5));
  const Result<DracoPayload> payload = DracoEncode(MakeRenderMesh(mesh, 3.2), 8, 8);
  ASSERT_TRUE(payload.ok()) << payload.error().message;
  EXPECT_GT(payload->position_bits, 8);
  EXPECT_TRUE(shape::CheckMesh(Surface(payload->decoded)).ok());
}

TEST(Draco, RefusesWhatCannotBeEncoded) {
  EXPECT_FALSE(DracoEncode(RenderMesh(), 14, 8).ok());
  RenderMesh index = Box(1, 1, 1);
  index.faces[0][0] = 100;
  EXPECT_FALSE(DracoEncode(index, 14, 8).ok());
  RenderMesh nan = Box(1, 1, 1);
  nan.positions[0].x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(DracoEncode(nan, 14, 8).ok());
  EXPECT_FALSE(DracoEncode(Box(1, 1, 1), 99, 8).ok());
}

TEST(Draco, DecodesNothingOutOfDamagedBytesButNeverDies) {
  const DracoPayload payload = *DracoEncode(Torus(12), 12, 8);
  const DracoAttributeIds ids{
      .position = payload.position_id, .normal = payload.normal_id, .colour = payload.colour_id};
  for (std::size_t n = 0; n < payload.bytes.size(); ++n) {
    EXPECT_FALSE(DracoDecode(std::string_view(payload.bytes).substr(0, n), ids).ok()) << n;
  }
  Random random(3);
  for (int n = 0; n < 2000; ++n) {
    std::string damaged = payload.bytes;
    for (int flips = 0; flips < 3; ++flips) {
      damaged[random.Index(damaged.size())] = static_cast<char>(random.Next());
    }
    const Result<DracoMesh> decoded = DracoDecode(damaged, ids);
    if (!decoded) continue;
    for (const auto& face : decoded->faces) {
      for (const auto v : face) ASSERT_LT(v, decoded->positions.size());
    }
  }
  EXPECT_FALSE(DracoDecode("", ids).ok());
  EXPECT_FALSE(DracoDecode("DRACO", ids).ok());
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
TEST(Draco, RefusesTruthValuesAsPositions) {
  const DracoAttributeIds ids = {.position = 0};
  const auto floats = DracoDecode(TriangleOf<float>(draco::DT_FLOAT32), ids);
  ASSERT_TRUE(floats.ok()) << floats.error().message;
  EXPECT_EQ(floats->positions.size(), 3U);
  EXPECT_TRUE(DracoDecode(TriangleOf<double>(draco::DT_FLOAT64), ids).ok());
  EXPECT_FALSE(DracoDecode(TriangleOf<bool>(draco::DT_BOOL), ids).ok());
  // The program's own scenes hold floats and nothing else.
  const DracoAttributeIds own = {.position = 0, .strict = true};
  EXPECT_TRUE(DracoDecode(TriangleOf<float>(draco::DT_FLOAT32), own).ok());
  EXPECT_FALSE(DracoDecode(TriangleOf<double>(draco::DT_FLOAT64), own).ok());
}

}  // namespace
}  // namespace deepslam::gltf
