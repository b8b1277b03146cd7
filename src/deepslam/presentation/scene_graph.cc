#include "deepslam/presentation/scene_graph.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/core/check.h"
#include "deepslam/layout/neighbours.h"
#include "deepslam/presentation/map_rounding.h"

namespace deepslam::presentation {
namespace {

constexpr double kVolumeStepM3 = 1e-6;  // a cubic centimetre

// Divided by a whole number, so that decimals are written as short as they are.
double RoundedTo(double value, double step) {
  const double per_unit = std::round(1 / step);
  return std::round(value * per_unit) / per_unit;
}

Eigen::Vector3d RoundedPlace(const Eigen::Vector3d& p) {
  return p.unaryExpr([](double value) { return RoundedTo(value, kMapPlaceStepM); });
}

GraphObject ToGraph(const CompactObject& object,
                    const TriangleMesh& mesh,
                    double volume_m3,
                    const ClassTable& classes) {
  Box3 box;
  Box3 box_world;
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    box.Extend(vertex.cast<double>());
    box_world.Extend(object.world_from_object * vertex.cast<double>());
  }
  const Eigen::Vector3d& origin = object.world_from_object.translation_m;
  GraphObject node;
  node.id = object.id;
  node.name = object.name;
  node.class_name = object.class_name;
  if (const ObjectClass* known = classes.Find(object.class_name))
    node.labels = known->labels_elsewhere;
  node.confidence = object.confidence;
  node.source = object.source;
  node.world_from_object = object.world_from_object;
  node.has_mesh = !mesh.empty();
  node.centre_world = RoundedPlace(box.empty() ? origin : object.world_from_object * box.Center());
  node.size_m = object.size_m;
  node.box_world.min = RoundedPlace(box.empty() ? origin : box_world.min);
  node.box_world.max = RoundedPlace(box.empty() ? origin : box_world.max);
  node.has_front = !classes.TraitsOf(object.class_name).yaw_free;
  node.volume_m3 = RoundedTo(std::max(0.0, volume_m3), kVolumeStepM3);
  node.room = object.room;
  node.credit = object.credit;
  node.note = object.note;
  return node;
}

void AddPlaces(const CompactObject& object, std::vector<GraphRelation>& relations) {
  if (object.against_wall) {
    const std::string wall = fmt::format("wall_{:02}", *object.against_wall);
    relations.push_back({object.name, Predicate::kAgainstWall, wall, {}});
    if (object.stands_on == kOnWall)
      relations.push_back({object.name, Predicate::kHangsOn, wall, {}});
  }
  if (object.room) {
    relations.push_back(
        {object.name, Predicate::kInRoom, fmt::format("room_{:02}", *object.room), {}});
  }
  if (!object.stands_on.empty() && object.stands_on != kOnWall)
    relations.push_back({object.name, Predicate::kStandsOn, object.stands_on, {}});
}

std::vector<std::vector<GraphRelation>> RelationsOf(const CompactMap& map,
                                                    std::span<const GraphObject> objects) {
  std::vector<layout::PlacedThing> things;
  for (const GraphObject& object : objects) {
    const Pose3 world_from_box = {object.world_from_object.rotation, object.centre_world};
    things.push_back({{world_from_box, object.size_m}, object.room, object.has_front});
  }
  std::vector<std::vector<GraphRelation>> relations(objects.size());
  for (const layout::Neighbours& pair : layout::NeighboursOf(things)) {
    const std::string& first = objects[pair.first].name;
    const std::string& second = objects[pair.second].name;
    const bool stands =
        map.objects[pair.first].stands_on == second || map.objects[pair.second].stands_on == first;
    const double distance_m = RoundedTo(pair.distance_m, kMapLayoutStepM);
    if (pair.before)
      relations[pair.first].push_back({first, Predicate::kInFrontOf, second, distance_m});
    if (pair.beside && !stands)
      relations[pair.first].push_back({first, Predicate::kNextTo, second, distance_m});
  }
  for (std::size_t n = 0; n < objects.size(); ++n) AddPlaces(map.objects[n], relations[n]);
  return relations;
}

}  // namespace

SceneGraph MakeSceneGraph(const CompactMap& map,
                          std::span<const TriangleMesh> meshes,
                          std::span<const double> volumes_m3,
                          const ClassTable& classes) {
  DEEPSLAM_CHECK(meshes.size() == map.objects.size() && volumes_m3.size() == map.objects.size(),
                 "one mesh and one volume per object");
  SceneGraph graph;
  graph.tool_version = map.tool_version;
  graph.capture_name = map.capture_name;
  graph.capture_hash = map.capture_hash;
  graph.verdict = {map.verdict, map.reasons};
  if (map.layout) graph.layout = *map.layout;
  for (std::size_t n = 0; n < meshes.size(); ++n)
    graph.objects.push_back(ToGraph(map.objects[n], meshes[n], volumes_m3[n], classes));
  for (std::vector<GraphRelation>& of_object : RelationsOf(map, graph.objects)) {
    std::sort(of_object.begin(), of_object.end(), [](const GraphRelation& a, const auto& b) {
      return std::tie(a.predicate, a.object) < std::tie(b.predicate, b.object);
    });
    graph.relations.insert(graph.relations.end(), of_object.begin(), of_object.end());
  }
  return graph;
}

}  // namespace deepslam::presentation
