#include "deepslam/presentation/scene_check.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "deepslam/presentation/map_rounding.h"

namespace deepslam::presentation {
namespace {

// What the scene's own numbers and its Draco grid may add to the rounding of the map's.
constexpr double kSceneSizeErrorM = 3e-4;
// Twice what four components rounded to a step turn by at most.
constexpr double kRotationErrorRad = 4 * kMapRotationStep;

std::string Vector(const Eigen::Vector3d& v) {
  return fmt::format("({:.4f}, {:.4f}, {:.4f})", v.x(), v.y(), v.z());
}

void CompareObject(const gltf::ValidatedObject& scene,
                   const CompactObject& entry,
                   std::vector<std::string>& differences) {
  const auto differ = [&](std::string_view what, const auto& in_scene, const auto& in_map) {
    differences.push_back(fmt::format("object {} ('{}'): {} is {} in the scene, {} in the map",
                                      entry.id.value,
                                      entry.name,
                                      what,
                                      in_scene,
                                      in_map));
  };
  if (scene.name != entry.name) differ("name", scene.name, entry.name);
  if (scene.class_name != entry.class_name) differ("class", scene.class_name, entry.class_name);
  const std::string source(NameOf(entry.source));
  if (scene.prior != source) differ("source of the shape", scene.prior, source);
  if (!scene.score || std::abs(*scene.score - entry.confidence) > kMapScoreStep) {
    differ("confidence", scene.score ? fmt::to_string(*scene.score) : "missing", entry.confidence);
  }
  const Eigen::Vector3d& place = scene.world_from_object.translation_m;
  const Eigen::Vector3d& map_place = entry.world_from_object.translation_m;
  if ((place - map_place).cwiseAbs().maxCoeff() > kMapPlaceStepM)
    differ("place", Vector(place), Vector(map_place));
  const double turn_rad =
      scene.world_from_object.rotation.angularDistance(entry.world_from_object.rotation);
  if (!(turn_rad <= kRotationErrorRad)) {
    differences.push_back(
        fmt::format("object {} ('{}'): is turned by {:.6f} rad between scene and map",
                    entry.id.value,
                    entry.name,
                    turn_rad));
  }
  constexpr double kSizeErrorM = kMapPlaceStepM + kSceneSizeErrorM;
  if ((scene.size_m - entry.size_m).cwiseAbs().maxCoeff() > kSizeErrorM)
    differ("size", Vector(scene.size_m), Vector(entry.size_m));
}

}  // namespace

namespace {

// Scenes may go without the layout; one that has it has all of it.
void CompareLayout(const gltf::ValidationReport& scene,
                   const CompactMap& map,
                   std::vector<std::string>& differences) {
  if (scene.parts.empty()) return;
  const auto compare = [&](std::string_view what, const auto& of_kind, std::size_t in_map) {
    const auto count = std::count_if(scene.parts.begin(), scene.parts.end(), of_kind);
    if (static_cast<std::size_t>(count) != in_map)
      differences.push_back(fmt::format("{}: {} in the scene, {} in the map", what, count, in_map));
  };
  const CompactLayout layout = map.layout.value_or(CompactLayout());
  compare(
      "walls", [](const auto& part) { return part.kind == "wall"; }, layout.walls.size());
  for (const OpeningKind kind : {OpeningKind::kDoor, OpeningKind::kWindow, OpeningKind::kPassage}) {
    const auto in_map = std::count_if(layout.openings.begin(),
                                      layout.openings.end(),
                                      [&](const auto& opening) { return opening.kind == kind; });
    compare(
        fmt::format("{}s", NameOf(kind)),
        [&](const auto& part) { return part.kind == NameOf(kind); },
        static_cast<std::size_t>(in_map));
  }
}

}  // namespace

std::vector<std::string> CompareWithMap(const gltf::ValidationReport& scene,
                                        const CompactMap& map) {
  std::vector<std::string> differences;
  std::map<int, const gltf::ValidatedObject*> by_instance;
  for (const gltf::ValidatedObject& object : scene.objects) by_instance[object.instance] = &object;
  for (const CompactObject& entry : map.objects) {
    const auto found = by_instance.find(entry.id.value);
    if (found == by_instance.end()) {
      differences.push_back(fmt::format(
          "object {} ('{}') of the map is not in the scene", entry.id.value, entry.name));
      continue;
    }
    CompareObject(*found->second, entry, differences);
    by_instance.erase(found);
  }
  for (const auto& [instance, object] : by_instance) {
    differences.push_back(
        fmt::format("object {} ('{}') of the scene is not in the map", instance, object->name));
  }
  CompareLayout(scene, map, differences);
  if (scene.has_ground != !map.ground_outline_m.empty()) {
    differences.push_back(fmt::format("ground: {} in the scene, {} in the map",
                                      scene.has_ground ? "there" : "none",
                                      map.ground_outline_m.empty() ? "none" : "there"));
  }
  return differences;
}

}  // namespace deepslam::presentation
