#include "deepslam/gltf/textured_model.h"

#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <numbers>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "deepslam/core/base64.h"
#include "deepslam/geometry/box.h"
#include "deepslam/gltf/validate.h"
#include "gltf/test_scene.h"

namespace deepslam::gltf {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;

constexpr std::size_t kManyFaces = 100'000;

// Files by name, in place of a folder.
using Files = std::map<std::string, std::string>;

ResourceLookup In(const Files& files) {
  return [&files](const std::string& path) -> std::optional<std::string> {
    const auto found = files.find(path);
    return found == files.end() ? std::nullopt : std::optional<std::string>(found->second);
  };
}

template <typename T>
std::string Packed(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

// A tetrahedron with corners at the origin and at 1, 2, 3 along x, y, z, faces outwards.
const std::vector<float> kCorners = {0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3};
const std::vector<std::uint16_t> kFaces = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};

struct Model {
  Json json;
  std::string buffer;

  int AddView(const std::string& bytes) {
    while (buffer.size() % 4 != 0) buffer += '\0';
    json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", bytes.size()}});
    buffer += bytes;
    return static_cast<int>(json["bufferViews"].size()) - 1;
  }
  int AddAccessor(const std::string& bytes, int component_type, const char* type, int count) {
    json["accessors"].push_back({{"bufferView", AddView(bytes)},
                                 {"componentType", component_type},
                                 {"type", type},
                                 {"count", count}});
    return static_cast<int>(json["accessors"].size()) - 1;
  }
  Json& primitive() { return json["meshes"][0]["primitives"][0]; }
  // The JSON with the buffer beside it as model.bin, and the same as one GLB.
  [[nodiscard]] std::string Gltf(Files& files) {
    files["model.bin"] = buffer;
    json["buffers"] = {{{"uri", "model.bin"}, {"byteLength", buffer.size()}}};
    return json.dump();
  }
  [[nodiscard]] std::string Glb() {
    json["buffers"] = {{{"byteLength", buffer.size()}}};
    std::string text = json.dump();
    while (text.size() % 4 != 0) text += ' ';
    std::string binary = buffer;
    while (binary.size() % 4 != 0) binary += '\0';
    const auto u32 = [](std::size_t value) {
      return Packed(std::vector<std::uint32_t>{static_cast<std::uint32_t>(value)});
    };
    return "glTF" + u32(2) + u32(12 + 8 + text.size() + 8 + binary.size()) + u32(text.size()) +
           "JSON" + text + u32(binary.size()) + std::string("BIN\0", 4) + binary;
  }
};

Model Tetrahedron() {
  Model model;
  model.json["asset"]["version"] = "2.0";
  const int positions = model.AddAccessor(Packed(kCorners), 5126, "VEC3", 4);
  const int indices = model.AddAccessor(Packed(kFaces), 5123, "SCALAR", 12);
  model.json["meshes"] = {
      {{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"indices", indices}}}}}};
  model.json["nodes"] = {{{"mesh", 0}}};
  model.json["scenes"] = {{{"nodes", {0}}}};
  return model;
}

Result<TexturedMesh> Read(const std::string& bytes, const Files& files = {}) {
  return ReadTexturedModel(bytes, In(files), kManyFaces);
}

std::string Refusal(const std::string& bytes, const Files& files = {}) {
  const Result<TexturedMesh> mesh = Read(bytes, files);
  return mesh.ok() ? std::string() : mesh.error().message;
}

// Positive where faces look out of a closed solid.
double Volume(const TexturedMesh& mesh) {
  double volume = 0;
  for (const TexturedMesh::Face& face : mesh.faces) {
    const auto p = [&](std::size_t c) { return mesh.vertices[face.vertices[c]]; };
    volume += p(0).dot(p(1).cross(p(2))) / 6;
  }
  return volume;
}

TEST(ReadTexturedModel, GltfWithItsBufferBesideAndGlbAreTheSame) {
  Model model = Tetrahedron();
  Files files;
  const std::string gltf = model.Gltf(files);
  const Result<TexturedMesh> beside = Read(gltf, files);
  ASSERT_TRUE(beside.ok()) << beside.error().message;
  ASSERT_EQ(beside->vertices.size(), 4U);
  EXPECT_EQ(beside->vertices[3], Eigen::Vector3d(0, 0, 3));
  EXPECT_EQ(beside->faces.size(), 4U);
  EXPECT_NEAR(Volume(*beside), 1, 1e-6);
  const Result<TexturedMesh> glb = Read(model.Glb());
  ASSERT_TRUE(glb.ok()) << glb.error().message;
  EXPECT_EQ(glb->vertices, beside->vertices);
  // The buffer inside the text.
  model.json["buffers"] = {
      {{"uri", "data:application/octet-stream;base64," + EncodeBase64(model.buffer)},
       {"byteLength", model.buffer.size()}}};
  const Result<TexturedMesh> inside = Read(model.json.dump());
  ASSERT_TRUE(inside.ok()) << inside.error().message;
  EXPECT_EQ(inside->vertices, beside->vertices);
}

TEST(ReadTexturedModel, NodesMoveTheirMeshesOneInsideTheOther) {
  Model model = Tetrahedron();
  const double half = std::numbers::sqrt2 / 2;
  // The child is twice as large and shifted along x; the parent turns by 90 deg about y and lifts.
  model.json["nodes"] = {
      {{"children", {1}}, {"rotation", {0, half, 0, half}}, {"translation", {0, 10, 0}}},
      {{"mesh", 0}, {"scale", {2, 2, 2}}, {"translation", {5, 0, 0}}}};
  const Result<TexturedMesh> mesh = Read(model.Glb());
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  // About y, x turns to -z and z to x.
  EXPECT_LT((mesh->vertices[1] - Eigen::Vector3d(0, 10, -7)).norm(), 1e-6);
  EXPECT_LT((mesh->vertices[2] - Eigen::Vector3d(0, 14, -5)).norm(), 1e-6);
  EXPECT_LT((mesh->vertices[3] - Eigen::Vector3d(6, 10, -5)).norm(), 1e-6);
  // The same as one matrix, by columns.
  model.json["nodes"] = {
      {{"mesh", 0}, {"matrix", {0, 0, -2, 0, 0, 2, 0, 0, 2, 0, 0, 0, 0, 10, -5, 1}}}};
  const Result<TexturedMesh> by_matrix = Read(model.Glb());
  ASSERT_TRUE(by_matrix.ok()) << by_matrix.error().message;
  for (std::size_t v = 0; v < 4; ++v)
    EXPECT_LT((by_matrix->vertices[v] - mesh->vertices[v]).norm(), 1e-6) << v;
}

TEST(ReadTexturedModel, MirroredNodesKeepTheirFacesLookingOut) {
  Model model = Tetrahedron();
  model.json["nodes"][0]["scale"] = {-1, 1, 1};
  const Result<TexturedMesh> mesh = Read(model.Glb());
  ASSERT_TRUE(mesh.ok());
  EXPECT_EQ(mesh->vertices[1], Eigen::Vector3d(-1, 0, 0));
  EXPECT_NEAR(Volume(*mesh), 1, 1e-6);
}

TEST(ReadTexturedModel, TakesTheDefaultSceneOnly) {
  Model model = Tetrahedron();
  model.json["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}, {"translation", {7, 0, 0}}}};
  model.json["scenes"] = {{{"nodes", {0}}}, {{"nodes", {1}}}};
  model.json["scene"] = 1;
  EXPECT_EQ(Read(model.Glb())->vertices[0], Eigen::Vector3d(7, 0, 0));
  model.json.erase("scenes");
  model.json.erase("scene");
  EXPECT_EQ(Read(model.Glb())->faces.size(), 8U) << "without scenes, all nodes";
}

TEST(ReadTexturedModel, StripsAndFansLookOutAsTrianglesDo) {
  // A square in the xy plane, seen from +z.
  const std::vector<float> strip = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
  const std::vector<float> fan = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  for (const auto& [mode, corners] : {std::pair(5, strip), std::pair(6, fan)}) {
    Model model = Tetrahedron();
    model.primitive() = {
        {"attributes", {{"POSITION", model.AddAccessor(Packed(corners), 5126, "VEC3", 4)}}},
        {"mode", mode}};
    const Result<TexturedMesh> mesh = Read(model.Glb());
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    double area = 0;
    for (const TexturedMesh::Face& face : mesh->faces) {
      const auto p = [&](std::size_t c) { return mesh->vertices[face.vertices[c]]; };
      area += (p(1) - p(0)).cross(p(2) - p(0)).z() / 2;
    }
    EXPECT_NEAR(area, 1, 1e-6) << "mode " << mode;
  }
}

TEST(ReadTexturedModel, QuantisedPositionsAndShortStridesAreRead) {
  Model model = Tetrahedron();
  // 16-bit numbers over [0, 1], padded to 8 bytes each; the node's scale brings them to size.
  const std::vector<std::uint16_t> quantised = {
      0, 0, 0, 9, 65535, 0, 0, 9, 0, 65535, 0, 9, 0, 0, 65535, 9};
  const int positions = model.AddAccessor(Packed(quantised), 5123, "VEC3", 4);
  model.json["accessors"][static_cast<std::size_t>(positions)]["normalized"] = true;
  model.json["bufferViews"].back()["byteStride"] = 8;
  model.primitive()["attributes"]["POSITION"] = positions;
  model.json["nodes"][0]["scale"] = {1, 2, 3};
  model.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  const Result<TexturedMesh> mesh = Read(model.Glb());
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_NEAR(Volume(*mesh), 1, 1e-6);
  EXPECT_LT((mesh->vertices[3] - Eigen::Vector3d(0, 0, 3)).norm(), 1e-6);
}

TEST(ReadTexturedModel, ReadsWhatTheSceneWriterCompressed) {
  GltfScene scene;
  scene.objects = {BoxObject("chair", 1)};
  scene.objects[0].world_from_object = Pose3();
  for (std::size_t n = 0; n < 8; ++n) scene.objects[0].mesh.colours.push_back({200, 40, 90});
  for (const bool draco : {true, false}) {
    GltfOptions options;
    options.draco = draco;
    const Result<std::string> glb = WriteGlb(scene, options);
    ASSERT_TRUE(glb.ok()) << glb.error().message;
    const Result<TexturedMesh> mesh = Read(*glb);
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    EXPECT_EQ(mesh->faces.size(), 12U);
    Box3 box;
    for (const Eigen::Vector3d& p : mesh->vertices) box.Extend(p);
    // x of ours is glTF's z.
    EXPECT_LT((box.Size() - Eigen::Vector3d(0.4, 0.9, 0.6)).norm(), 1e-3);
    EXPECT_GT(Volume(*mesh), 0.2);
    // The vertex colours come back as the display values they were.
    ASSERT_EQ(mesh->colours.size(), mesh->vertices.size());
    EXPECT_LT((mesh->colours[0] - Eigen::Vector3f(200, 40, 90) / 255).norm(), 0.005) << draco;
  }
}

TEST(ReadTexturedModel, MaterialsBecomeDisplayColoursAndTexturePlaces) {
  Model model = Tetrahedron();
  const std::vector<float> places = {0, 0, 1, 0, 0, 1, 0.25F, 0.5F};
  model.primitive()["attributes"]["TEXCOORD_1"] =
      model.AddAccessor(Packed(places), 5126, "VEC2", 4);
  model.primitive()["material"] = 0;
  model.json["materials"] = {{{"pbrMetallicRoughness",
                               {{"baseColorFactor", {0.2140, 1, 0, 1}},
                                {"baseColorTexture", {{"index", 0}, {"texCoord", 1}}}}}}};
  model.json["textures"] = {{{"source", 0}}};
  model.json["images"] = {{{"uri", "my%20wood.png"}}};
  const Files files = {{"my wood.png", "bytes of a picture"}};
  const Result<TexturedMesh> mesh = Read(model.Glb(), files);
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  ASSERT_EQ(mesh->materials.size(), 1U);
  // 0.2140 of the light is the middle of the display's range.
  EXPECT_LT((mesh->materials[0].tint - Eigen::Vector3f(0.5F, 1, 0)).norm(), 1e-3F);
  EXPECT_FALSE(mesh->materials[0].shiny);
  ASSERT_EQ(mesh->textures.size(), 1U);
  EXPECT_EQ(mesh->textures[0], "bytes of a picture");
  EXPECT_EQ(mesh->materials[0].texture, 0);
  // The last face's corners are vertices 1, 2, 3; v runs upwards here.
  const TexturedMesh::Face& face = mesh->faces[3];
  EXPECT_LT((face.places[0] - Eigen::Vector2f(1, 1)).norm(), 1e-6F);
  EXPECT_LT((face.places[1] - Eigen::Vector2f(0, 0)).norm(), 1e-6F);
  EXPECT_LT((face.places[2] - Eigen::Vector2f(0.25F, 0.5F)).norm(), 1e-6F);

  model.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] = {
      {"KHR_texture_transform", {{"offset", {0.5, 0.25}}, {"scale", {2, 4}}}}};
  const Eigen::Vector2f moved = Read(model.Glb(), files)->faces[3].places[2];
  EXPECT_LT((moved - Eigen::Vector2f(1.0F, 1 - 2.25F)).norm(), 1e-6F);

  EXPECT_EQ(Read(model.Glb())->materials[0].texture, -1) << "a missing texture is left out";
}

TEST(ReadTexturedModel, GlassAndPolishedMetalAreShiny) {
  const auto shiny = [](const Json& material) {
    Model model = Tetrahedron();
    model.json["materials"] = {material};
    return Read(model.Glb())->materials[0].shiny;
  };
  EXPECT_TRUE(shiny(
      {{"alphaMode", "BLEND"}, {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0.2}}}}}));
  EXPECT_TRUE(
      shiny({{"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 0.9}}}}}}));
  EXPECT_TRUE(shiny({{"pbrMetallicRoughness", {{"roughnessFactor", 0.05}}}}));
  EXPECT_FALSE(shiny({{"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0.2}}}}}));
  EXPECT_FALSE(shiny({{"name", "wood"}})) << "glTF's default is metal, and rough";
}

TEST(ReadTexturedModel, RefusesByField) {
  EXPECT_THAT(Refusal(""), HasSubstr("damaged"));
  EXPECT_THAT(Refusal("glTF"), HasSubstr("GLB"));
  EXPECT_THAT(Refusal("{}"), HasSubstr("asset.version"));
  EXPECT_THAT(Refusal(std::string(5000, '[')), HasSubstr("nested"));
  Files files;
  const std::string text = Tetrahedron().Gltf(files);
  EXPECT_THAT(Refusal(text, {}),
              testing::AllOf(HasSubstr("buffers[0].uri"), HasSubstr("model.bin")));
  files["model.bin"].resize(50);
  EXPECT_THAT(Refusal(text, files), HasSubstr("cut off"));
  EXPECT_THAT(Refusal(text.substr(0, text.size() / 2), files), HasSubstr("damaged"));

  const auto refused = [](const std::function<void(Json&)>& change) {
    Model model = Tetrahedron();
    change(model.json);
    return Refusal(model.Glb());
  };
  EXPECT_THAT(refused([](Json& j) { j["accessors"][1]["count"] = 4'000'000'000; }),
              testing::AllOf(HasSubstr("accessors[1].count"), HasSubstr("4000000000")));
  EXPECT_THAT(refused([](Json& j) { j["accessors"][0]["count"] = 5; }), HasSubstr("accessors[0]"));
  EXPECT_THAT(refused([](Json& j) { j["accessors"][0]["byteOffset"] = 18446744073709551615U; }),
              HasSubstr("accessors[0]"));
  EXPECT_THAT(refused([](Json& j) { j["bufferViews"][0]["byteLength"] = 1'000'000; }),
              HasSubstr("bufferViews[0]"));
  EXPECT_THAT(refused([](Json& j) { j["bufferViews"][0]["buffer"] = 3; }), HasSubstr("3 of 1"));
  EXPECT_THAT(refused([](Json& j) { j["accessors"][0]["count"] = 3; }), HasSubstr("vertex 3 of 3"));
  EXPECT_THAT(refused([](Json& j) {
                j["accessors"][0]["sparse"] = {{"count", 1}};
              }),
              HasSubstr("sparse"));
  EXPECT_THAT(refused([](Json& j) { j["accessors"][0].erase("bufferView"); }),
              HasSubstr("has no data"));
  EXPECT_THAT(refused([](Json& j) { j["accessors"][1]["componentType"] = 5122; }),
              HasSubstr("unsigned"));
  EXPECT_THAT(refused([](Json& j) {
                j["nodes"] = {{{"mesh", 0}, {"children", {0}}}};
              }),
              HasSubstr("nodes[0]"));
  EXPECT_THAT(refused([](Json& j) { j["nodes"][0]["scale"] = {1, 2}; }), HasSubstr("3 finite"));
  EXPECT_THAT(refused([](Json& j) {
                j["nodes"][0]["rotation"] = {0, 0, 0, 0};
              }),
              HasSubstr("quaternion"));
  EXPECT_THAT(refused([](Json& j) { j["meshes"][0]["primitives"][0]["mode"] = 1; }),
              HasSubstr("no triangles"));
  EXPECT_THAT(refused([](Json& j) { j["scenes"][0]["nodes"] = {9}; }), HasSubstr("scenes[0]"));
  EXPECT_THAT(refused([](Json& j) { j["extensionsRequired"] = {"EXT_meshopt_compression"}; }),
              HasSubstr("EXT_meshopt_compression"));
}

TEST(ReadTexturedModel, NeverAsksForFilesElsewhere) {
  for (const char* uri : {"../model.bin",
                          "/etc/passwd",
                          "a/../../b",
                          "http://x/y.bin",
                          "..\\m.bin",
                          "%2e%2e/model.bin",
                          "file:///etc/passwd"}) {
    Model model = Tetrahedron();
    model.json["buffers"] = {{{"uri", uri}, {"byteLength", model.buffer.size()}}};
    const ResourceLookup any = [&](const std::string& path) -> std::optional<std::string> {
      ADD_FAILURE() << uri << " asked for " << path;
      return model.buffer;
    };
    EXPECT_FALSE(ReadTexturedModel(model.json.dump(), any, kManyFaces).ok()) << uri;
  }
}

TEST(ReadTexturedModel, StopsAtTheLimitOfFaces) {
  Model model = Tetrahedron();
  // One small mesh, standing in many nodes.
  Json nodes = Json::array();
  Json roots = Json::array();
  for (int n = 0; n < 100; ++n) {
    nodes.push_back({{"mesh", 0}});
    roots.push_back(n);
  }
  model.json["nodes"] = nodes;
  model.json["scenes"] = {{{"nodes", roots}}};
  EXPECT_EQ(Read(model.Glb())->faces.size(), 400U);
  const Result<TexturedMesh> mesh = ReadTexturedModel(model.Glb(), In({}), 350);
  ASSERT_FALSE(mesh.ok());
  EXPECT_THAT(mesh.error().message,
              testing::AllOf(HasSubstr("more than 350"), HasSubstr("coarser")));
}

// Scenes of the program's own come to furniture as validation sees them.
TEST(ReadTexturedModel, ReadsOfSceneFilesWhatValidationFindsInThem) {
  GltfScene scene;
  scene.objects = {BoxObject("chair", 1), BoxObject("chair", 2), BoxObject("table", 1)};
  for (const bool draco : {true, false}) {
    GltfOptions options;
    options.draco = draco;
    const std::string glb = *WriteGlb(scene, options);
    const ValidationReport report = ValidateGlb(glb);
    ASSERT_TRUE(report.ok()) << report.errors.front();
    const Result<TexturedMesh> mesh = Read(glb);
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    EXPECT_EQ(static_cast<std::int64_t>(mesh->faces.size()), report.num_faces);
    EXPECT_EQ(static_cast<std::int64_t>(mesh->vertices.size()), report.num_vertices);
    double volume = 0;
    for (const ValidatedObject& object : report.objects) volume += object.volume_m3;
    EXPECT_NEAR(Volume(*mesh), volume, 1e-5) << "draco " << draco;
  }
}

// What the standard forbids and a reader can do without is no reason to refuse furniture, but one
// to find fault with a scene.
TEST(ReadTexturedModel, IsLenientWhereValidationIsStrict) {
  GltfScene scene;
  scene.objects = {BoxObject("chair", 1)};
  const std::string glb = *WriteGlb(scene, Plain());
  const std::vector<std::function<void(Json&)>> breaches = {
      [](Json& j) { j["asset"]["version"] = "2.1"; },
      [](Json& j) {
        j["nodes"][0]["rotation"] = {0, 0, 0, 1.1};
      },
      [](Json& j) { j["accessors"][0]["max"] = "large"; },
      [](Json& j) {
        j["accessors"].push_back({{"sparse", {{"count", 1}}}});
      },
      [](Json& j) {
        j["bufferViews"].push_back({{"buffer", 0}, {"byteLength", 1'000'000}});
      },
      [](Json& j) { j["nodes"][0]["camera"] = 77; },
  };
  for (std::size_t n = 0; n < breaches.size(); ++n) {
    Json json = Json::parse(JsonOf(glb));
    breaches[n](json);
    const std::string breached = WithJson(glb, json.dump());
    EXPECT_FALSE(ValidateGlb(breached).ok()) << n;
    const Result<TexturedMesh> mesh = Read(breached);
    EXPECT_TRUE(mesh.ok()) << n << ": " << mesh.error().message;
  }
}

TEST(ReadTexturedModel, DamagedBytesAreNeverWorseThanAnError) {
  GltfScene scene;
  scene.objects = {BoxObject("chair", 1)};
  std::vector<std::string> samples = {Tetrahedron().Glb(), *WriteGlb(scene, GltfOptions())};
  for (const std::string& whole : samples) {
    for (std::size_t length = 0; length < whole.size(); length += 3)
      EXPECT_FALSE(Read(whole.substr(0, length)).ok()) << length;
    for (std::size_t at = 0; at < whole.size(); ++at) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ (at % 2 == 0 ? 0xFF : 0x11));
      const Result<TexturedMesh> mesh = Read(damaged);
      if (!mesh.ok()) continue;
      for (const TexturedMesh::Face& face : mesh->faces) {
        for (const std::uint32_t v : face.vertices) ASSERT_LT(v, mesh->vertices.size());
      }
    }
  }
}

}  // namespace
}  // namespace deepslam::gltf
