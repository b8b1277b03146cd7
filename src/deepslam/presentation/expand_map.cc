#include "deepslam/presentation/expand_map.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/core/parallel.h"
#include "deepslam/core/sha256.h"
#include "deepslam/mesh/ground_polygon.h"
#include "deepslam/presentation/compact_layout.h"
#include "deepslam/presentation/layout_parts.h"
#include "deepslam/shape/binvox.h"
#include "deepslam/shape/stretch.h"
#include "deepslam/shape/voxel_code.h"

namespace deepslam::presentation {
namespace {

Result<VoxelGrid> LibraryShape(const CompactShape& shape, const ModelLibrary& library) {
  const auto found =
      std::find_if(library.models.begin(), library.models.end(), [&](const LibraryModel& model) {
        return model.id == shape.library_id;
      });
  if (found == library.models.end()) {
    return InvalidInput(fmt::format(
        "the furniture library holds no model {}; take the library the map was made with",
        shape.library_id));
  }
  if (shape.library_checksum.empty() || !found->checksum.starts_with(shape.library_checksum)) {
    return InvalidInput(
        fmt::format("the library's model {} is another one than the map was made with (checksum "
                    "{:.12}, expected {:.12}); take the library the map was made with",
                    shape.library_id,
                    found->checksum,
                    shape.library_checksum));
  }
  if (shape.stretch == Eigen::Vector3d::Ones()) return found->shape;
  VoxelGrid grid = shape::StretchGrid(found->shape, shape.stretch);
  if (!shape.voxels_checksum.empty() &&
      !Sha256Hex(shape::WriteBinvox(grid)).starts_with(shape.voxels_checksum)) {
    return InvalidInput(fmt::format(
        "model {} stretched by this version is another one than the map was made with; take the "
        "version the map names",
        shape.library_id));
  }
  return grid;
}

// The voxels a shape of a map stands for, its own or a library's.
Result<VoxelGrid> ShapeOf(const CompactShape& shape, const ModelLibrary* library) {
  if (!shape.voxel_code.empty()) return shape::DecodeVoxels(shape.voxel_code);
  if (library != nullptr) return LibraryShape(shape, *library);
  return InvalidInput(fmt::format(
      "needs model {} of the furniture library; name its folder by --library", shape.library_id));
}

// The shapes of a map, each once: one chair a thousand times is one shape.
using ShapeKey =
    std::tuple<std::string, double, double, double, std::string, std::string, std::string>;
ShapeKey KeyOf(const CompactShape& shape) {
  const Eigen::Vector3d& stretch = shape.stretch;
  return {shape.library_id,
          stretch.x(),
          stretch.y(),
          stretch.z(),
          shape.library_checksum,
          shape.voxels_checksum,
          shape.voxel_code};
}
using UnitMeshes = std::map<ShapeKey, std::optional<Result<TriangleMesh>>>;

// In object units.
UnitMeshes MakeUnitMeshes(const CompactMap& map,
                          const ModelLibrary* library,
                          const mesh::ObjectMeshOptions& options) {
  UnitMeshes meshes;
  std::map<ShapeKey, const CompactShape*> shapes;
  for (const CompactObject& entry : map.objects) {
    if (!entry.shape.voxel_code.empty() || !entry.shape.library_id.empty())
      shapes.emplace(KeyOf(entry.shape), &entry.shape);
  }
  std::vector<std::pair<const CompactShape*, std::optional<Result<TriangleMesh>>*>> work;
  for (const auto& [key, shape] : shapes) work.emplace_back(shape, &meshes[key]);
  ParallelFor(work.size(), [&](std::size_t i) {
    const Result<VoxelGrid> grid = ShapeOf(*work[i].first, library);
    *work[i].second =
        grid.ok() ? mesh::MakeObjectMesh(*grid, 1.0, options) : Result<TriangleMesh>(grid.error());
  });
  return meshes;
}

Result<TriangleMesh> ExpandShape(const CompactObject& entry, const UnitMeshes& unit_meshes) {
  const CompactShape& shape = entry.shape;
  if (const auto unit = unit_meshes.find(KeyOf(shape)); unit != unit_meshes.end()) {
    Result<TriangleMesh> mesh = *unit->second;
    if (!mesh.ok()) return mesh.error();
    for (Eigen::Vector3f& vertex : mesh->vertices) vertex *= static_cast<float>(entry.scale_m);
    return mesh;
  }
  if (!shape.latents.empty()) {
    return InvalidInput(fmt::format(
        "its shape is {} latents of a network, and no decoder for class {} is installed",
        shape.latents.size(),
        entry.class_name));
  }
  return TriangleMesh();  // an object without a surface, as in the scene
}

gltf::GltfObject ToGltf(const CompactObject& entry, TriangleMesh mesh, const CompactMap& map) {
  gltf::GltfObject object;
  object.name = entry.name;
  object.class_name = entry.class_name;
  object.instance = entry.id.value;
  object.score = entry.confidence;
  object.source = NameOf(entry.source);
  object.mesh = std::move(mesh);
  object.world_from_object = entry.world_from_object;
  if (const auto colour = map.class_colours.find(entry.class_name);
      colour != map.class_colours.end()) {
    object.class_colour = colour->second;
  }
  object.credit = entry.credit;
  if (!entry.shape.voxel_code.empty()) {
    object.model = entry.shape.voxel_code;
    object.scale_m = entry.scale_m;
  } else if (!entry.shape.library_id.empty()) {
    const Eigen::Vector3d& stretch = entry.shape.stretch;
    object.model =
        fmt::format("{} {} {} {}", entry.shape.library_id, stretch.x(), stretch.y(), stretch.z());
    object.scale_m = entry.scale_m;
  }
  return object;
}

}  // namespace

bool NeedsLibrary(const CompactMap& map) {
  return std::any_of(map.objects.begin(), map.objects.end(), [](const CompactObject& entry) {
    return entry.shape.voxel_code.empty() && !entry.shape.library_id.empty();
  });
}

Result<gltf::GltfScene> ExpandMap(const CompactMap& map,
                                  const ModelLibrary* library,
                                  const mesh::ObjectMeshOptions& options,
                                  std::string_view tool_version) {
  const UnitMeshes unit_meshes = MakeUnitMeshes(map, library, options);
  gltf::GltfScene scene;
  for (const CompactObject& entry : map.objects) {
    Result<TriangleMesh> mesh = ExpandShape(entry, unit_meshes);
    if (!mesh.ok()) {
      return Error{mesh.error().code,
                   fmt::format("object {}: {}", entry.name, mesh.error().message)};
    }
    scene.objects.push_back(ToGltf(entry, std::move(mesh).value(), map));
  }
  if (!map.ground_outline_m.empty()) {
    Result<TriangleMesh> ground = mesh::TriangulateOutline(map.ground_outline_m);
    if (!ground.ok()) return ground.error();
    scene.ground = std::move(ground).value();
  }
  if (map.layout) scene.parts = LayoutParts(LayoutOf(*map.layout), TriangleMesh());
  scene.generator = fmt::format("deepslam {}", tool_version);
  scene.provenance = {{"capture_sha256", map.capture_hash},
                      {"deepslam_version", map.tool_version},
                      {"expanded_from", "map.json"}};
  return scene;
}

}  // namespace deepslam::presentation
