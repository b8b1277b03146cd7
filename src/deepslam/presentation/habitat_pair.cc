#include "deepslam/presentation/habitat_pair.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

namespace deepslam::presentation {
namespace {

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
  for (const gltf::GltfPart& part : scene.parts) {
    semantic.parts.push_back(part);
    semantic.parts.back().opacity = 1;
    if (!part.mesh_world.empty()) label(semantic.parts.back().mesh_world, part.kind);
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

}  // namespace deepslam::presentation
