#include "deepslam/presentation/compact_map.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "deepslam/geometry/box.h"
#include "deepslam/layout/relations.h"
#include "deepslam/mesh/ground_polygon.h"
#include "deepslam/presentation/compact_layout.h"
#include "deepslam/presentation/map_rounding.h"

namespace deepslam::presentation {
namespace {

CompactShape ShapeOf(const MapObject& object, bool has_surface, const ShapeCodes& codes) {
  CompactShape shape;
  for (const ShapeCandidate& candidate : codes.candidates) {
    if (candidate.id != object.chosen) continue;
    shape.latents = candidate.latents;
    shape.stretch = candidate.stretch;
  }
  if (!object.library_id.empty()) {
    shape.library_id = object.library_id;
    const auto checksum = codes.library_sha256.find(object.library_id);
    if (checksum != codes.library_sha256.end())
      shape.library_checksum = checksum->second.substr(0, kMapChecksumDigits);
    shape.voxels_checksum =
        codes.models.at(object.model).voxels_sha256.substr(0, kMapChecksumDigits);
  } else if (has_surface) {  // a network's too: the map is then whole without its decoder
    shape.voxel_code = codes.models.at(object.model).voxel_code;
  }
  return shape;
}

CompactObject ToCompact(const MapObject& object,
                        const TriangleMesh& mesh,
                        const ShapeCodes& codes) {
  Box3 box;
  for (const Eigen::Vector3f& vertex : mesh.vertices) box.Extend(vertex.cast<double>());
  return {object.id,
          ObjectName(object),
          object.class_name,
          std::clamp(object.confidence, 0.0, 1.0),
          object.source,
          object.world_from_object,
          object.scale_m,
          box.Size(),
          object.credit,
          object.note,
          ShapeOf(object, !mesh.empty(), codes)};
}

// Where the objects are in the layout. Where no ground was seen, heights say nothing.
void PlaceObjects(const FinishedMap& finished, std::vector<CompactObject>& objects) {
  std::vector<layout::ThingBox> boxes;
  for (const CompactObject& object : objects)
    boxes.push_back({object.world_from_object, object.size_m});
  const std::vector<layout::Relations> relations =
      layout::RelationsOf(finished.layout_world, boxes);
  for (std::size_t n = 0; n < objects.size(); ++n) {
    objects[n].room = relations[n].room;
    objects[n].against_wall = relations[n].against_wall;
    if (!finished.map.has_ground) continue;
    if (relations[n].support == layout::Support::kFloor) objects[n].stands_on = kOnFloor;
    if (relations[n].support == layout::Support::kWall) objects[n].stands_on = kOnWall;
    if (relations[n].support == layout::Support::kThing)
      objects[n].stands_on = objects[*relations[n].on].name;
  }
}

}  // namespace

CompactMap MakeCompactMap(const FinishedMap& finished,
                          const gltf::GltfScene& scene,
                          const ShapeCodes& codes,
                          const MapNotes& notes) {
  CompactMap map;
  map.tool_version = notes.run.tool_version;
  map.capture_name = notes.run.capture_name;
  map.capture_hash = notes.run.capture_sha256;
  if (finished.map.has_ground) map.ground_world = finished.map.ground_world;
  if (scene.ground) map.ground_outline_m = mesh::OutlineOf(*scene.ground);
  for (const gltf::GltfObject& object : scene.objects)
    map.class_colours[object.class_name] = object.class_colour;
  map.mesh_options = notes.mesh_options;
  map.verdict = notes.verdict.verdict;
  map.reasons = notes.verdict.reasons;
  for (std::size_t i = 0; i < finished.meshes.size(); ++i)
    map.objects.push_back(ToCompact(finished.map.map.objects[i], finished.meshes[i], codes));
  map.layout = CompactLayoutOf(finished.layout_world);
  PlaceObjects(finished, map.objects);
  return Rounded(std::move(map));
}

}  // namespace deepslam::presentation
