#include "deepslam/presentation/scenes_elsewhere.h"

#include <cstddef>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/check.h"

namespace deepslam::presentation {
namespace {

usd::UsdPrim ObjectPrim(const gltf::GltfObject& object, const CompactObject& entry) {
  usd::UsdPrim prim;
  prim.name = object.name;
  prim.label = object.class_name;
  prim.world_from_prim = entry.world_from_object;
  prim.mesh = object.mesh;
  prim.colour = object.class_colour;
  prim.texts = {{"class", object.class_name}, {"source", object.source}};
  if (!object.credit.empty()) prim.texts["credit"] = object.credit;
  if (!entry.stands_on.empty()) prim.texts["stands_on"] = entry.stands_on;
  prim.numbers = {{"instance", object.instance}, {"confidence", entry.confidence}};
  if (entry.room) prim.numbers["room"] = *entry.room;
  return prim;
}

usd::UsdPrim PartPrim(const gltf::GltfPart& part) {
  usd::UsdPrim prim;
  prim.name = part.name;
  prim.label = part.kind;
  prim.mesh = part.mesh_world;
  prim.colour = part.colour;
  prim.opacity = part.opacity;
  prim.numbers = part.figures;
  prim.numbers["id"] = part.id;
  if (part.wall) prim.numbers["wall"] = *part.wall;
  return prim;
}

usd::UsdPrim SurroundingsPrim(const char* name, const char* label, const TriangleMesh& mesh) {
  usd::UsdPrim prim;
  prim.name = name;
  prim.label = label;
  prim.mesh = mesh;
  return prim;
}

// A mean of the mesh's colours, where it has any: simulators show one.
Rgb8 MeanColourOf(const TriangleMesh& mesh, Rgb8 otherwise) {
  if (mesh.colours.empty()) return otherwise;
  std::uint64_t red = 0;
  std::uint64_t green = 0;
  std::uint64_t blue = 0;
  for (const Rgb8& colour : mesh.colours) {
    red += colour.r;
    green += colour.g;
    blue += colour.b;
  }
  const auto mean = [&](std::uint64_t sum) {
    return static_cast<std::uint8_t>(sum / mesh.colours.size());
  };
  return {mean(red), mean(green), mean(blue)};
}

}  // namespace

usd::UsdScene UsdSceneOf(const gltf::GltfScene& scene,
                         const CompactMap& map,
                         const RigidBodies* bodies) {
  DEEPSLAM_CHECK(scene.objects.size() == map.objects.size(), "one entry of the map per object");
  usd::UsdScene out;
  out.provenance = scene.provenance;
  usd::UsdGroup objects{"Objects", {}};
  for (std::size_t n = 0; n < scene.objects.size(); ++n) {
    objects.prims.push_back(ObjectPrim(scene.objects[n], map.objects[n]));
    if (bodies != nullptr) objects.prims.back().body = bodies->objects[n];
  }
  usd::UsdGroup layout{"Layout", {}};
  for (std::size_t n = 0; n < scene.parts.size(); ++n) {
    layout.prims.push_back(PartPrim(scene.parts[n]));
    if (bodies != nullptr) layout.prims.back().body = bodies->parts[n];
  }
  usd::UsdGroup surroundings{"Surroundings", {}};
  if (scene.ground) {
    surroundings.prims.push_back(SurroundingsPrim("ground", "floor", *scene.ground));
    surroundings.prims.back().two_sided = true;
    if (bodies != nullptr)
      surroundings.prims.back().body.emplace();  // as it is: what things rest on
  }
  if (scene.room) surroundings.prims.push_back(SurroundingsPrim("room", "unknown", *scene.room));
  out.groups = {std::move(objects), std::move(layout), std::move(surroundings)};
  return out;
}

simulator::SimulatorScene SimulatorSceneOf(const gltf::GltfScene& scene,
                                           const CompactMap& map,
                                           const RigidBodies& bodies) {
  DEEPSLAM_CHECK(scene.objects.size() == map.objects.size(), "one entry of the map per object");
  simulator::SimulatorScene out;
  out.has_floor = map.ground_world.has_value();
  out.provenance = fmt::format("{} of {}", scene.generator, map.capture_name);
  for (std::size_t n = 0; n < scene.objects.size(); ++n) {
    const gltf::GltfObject& object = scene.objects[n];
    if (object.mesh.empty()) continue;
    out.things.push_back({object.name,
                          object.class_name,
                          map.objects[n].world_from_object,
                          object.mesh,
                          MeanColourOf(object.mesh, object.class_colour),
                          1,
                          bodies.objects[n]});
  }
  for (std::size_t n = 0; n < scene.parts.size(); ++n) {
    const gltf::GltfPart& part = scene.parts[n];
    if (part.mesh_world.empty()) continue;
    out.things.push_back({part.name,
                          part.kind,
                          {},
                          part.mesh_world,
                          MeanColourOf(part.mesh_world, part.colour),
                          part.opacity,
                          bodies.parts[n]});
  }
  return out;
}

}  // namespace deepslam::presentation
