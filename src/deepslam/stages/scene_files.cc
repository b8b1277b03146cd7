#include "deepslam/stages/scene_files.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/ply.h"

namespace deepslam::stages {
namespace {

constexpr Rgb8 kPlain{176, 170, 160};  // of surfaces without colours of their own

void Append(const TriangleMesh& mesh,
            const Pose3& world_from_mesh,
            Rgb8 plain,
            int label,
            artifact::PlyMesh& ply) {
  const auto first = static_cast<std::uint32_t>(ply.mesh.vertices.size());
  for (const Eigen::Vector3f& p : mesh.vertices) {
    ply.mesh.vertices.emplace_back((world_from_mesh * p.cast<double>()).cast<float>());
  }
  for (const auto& face : mesh.faces) {
    ply.mesh.faces.push_back({face[0] + first, face[1] + first, face[2] + first});
  }
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    ply.mesh.colours.push_back(mesh.colours.empty() ? plain : mesh.colours[v]);
  }
  ply.labels.resize(ply.mesh.vertices.size(), label);
}

// Colours that differ in their upper bits, so that neighbours in the list look different as well:
// the bits of the number go to red, green and blue in turn, the lowest bit to the highest place.
Rgb8 ColourOf(int number) {
  std::array<int, 3> channels = {0, 0, 0};
  for (int bit = 0; bit < 24; ++bit) {
    const int value = (number >> bit) & 1;
    channels[static_cast<std::size_t>(bit % 3)] |= value << (7 - bit / 3);
  }
  const auto channel = [&](std::size_t n) { return static_cast<std::uint8_t>(channels[n]); };
  return {channel(0), channel(1), channel(2)};
}

std::string QuotedCategory(const std::string& name) {
  std::string text = name;
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '"' || c == '\n' || c == '\r'; }, '_');
  return '"' + text + '"';
}

}  // namespace

Result<std::string> EncodeLabelledPly(const gltf::GltfScene& scene) {
  artifact::PlyMesh ply;
  for (const gltf::GltfObject& object : scene.objects) {
    Append(object.mesh, object.world_from_object, object.class_colour, object.instance, ply);
  }
  if (scene.ground) Append(*scene.ground, {}, kPlain, kGroundLabel, ply);
  if (scene.room) Append(*scene.room, {}, kPlain, kRoomLabel, ply);
  return artifact::EncodePly(ply, "scene.ply");
}

Result<HabitatPair> EncodeHabitatPair(const gltf::GltfScene& scene) {
  gltf::GltfScene semantic;
  semantic.generator = scene.generator;
  semantic.provenance = scene.provenance;
  HabitatPair pair;
  pair.txt = "HM3D Semantic Annotations\n";
  int number = 0;  // 0 is black: nothing
  const auto label = [&](TriangleMesh& mesh, const std::string& category) {
    ++number;
    const Rgb8 colour = ColourOf(number);
    mesh.colours.assign(mesh.vertices.size(), colour);
    pair.txt += fmt::format("{},{:02X}{:02X}{:02X},{},0\n",
                            number,
                            colour.r,
                            colour.g,
                            colour.b,
                            QuotedCategory(category));
  };
  for (const gltf::GltfObject& object : scene.objects) {
    semantic.objects.push_back(object);
    label(semantic.objects.back().mesh, object.class_name);
  }
  semantic.ground = scene.ground;
  if (semantic.ground) label(*semantic.ground, "floor");
  semantic.room = scene.room;
  if (semantic.room) label(*semantic.room, "unknown");
  Result<std::string> glb = gltf::WriteGlb(semantic, {.draco = false, .cameras = false});
  if (!glb.ok()) return glb.error();
  pair.glb = std::move(glb).value();
  return pair;
}

}  // namespace deepslam::stages
