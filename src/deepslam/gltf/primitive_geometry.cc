#include "deepslam/gltf/primitive_geometry.h"

#include <string>
#include <utility>

#include "deepslam/gltf/draco_decode.h"

namespace deepslam::gltf {
namespace {

std::string PlacesName(const GeometryWanted& wanted) {
  return "TEXCOORD_" + std::to_string(wanted.texture_set);
}

// The accessor that `reference` names, of `least` to `most` components and with data.
std::optional<GltfAccessor> Values(GltfBuffers& buffers,
                                   const JsonPlace& reference,
                                   int least,
                                   int most) {
  std::optional<GltfAccessor> accessor = buffers.Accessor(reference);
  if (!accessor) return std::nullopt;
  if (accessor->is_matrix || accessor->num_components < least || accessor->num_components > most) {
    reference.Error("names " + accessor->place + ", which has another type than it needs");
    return std::nullopt;
  }
  if (!accessor->has_data) {
    reference.Error("names " + accessor->place + ", which has no data");
    return std::nullopt;
  }
  return accessor;
}

template <int N>
std::vector<Eigen::Matrix<float, N, 1>> Vectors(const GltfAccessor& accessor) {
  std::vector<Eigen::Matrix<float, N, 1>> vectors(accessor.count);
  for (std::uint64_t n = 0; n < accessor.count; ++n) {
    for (int component = 0; component < N; ++component)
      vectors[n][component] = accessor.At(n, component);
  }
  return vectors;
}

bool ReadCorners(GltfBuffers& buffers,
                 const JsonPlace& primitive,
                 std::size_t max_faces,
                 PrimitiveGeometry& geometry) {
  const JsonPlace place = primitive["indices"];
  const std::optional<GltfAccessor> indices = Values(buffers, place, 1, 1);
  if (place.exists() && !indices) return false;
  if (indices && indices->component_type != kUnsignedByte &&
      indices->component_type != kUnsignedShort && indices->component_type != kUnsignedInt) {
    place.Error("names " + indices->place + ", which holds no unsigned numbers");
    return false;
  }
  if (indices && !indices->packed) place.Breach("names numbers with a stride");
  const std::uint64_t count = indices ? indices->count : geometry.positions.size();
  if (count / 3 > max_faces) {
    place.Error("brings " + std::to_string(count) + " corners, too many");
    return false;
  }
  geometry.corners.resize(count);
  for (std::uint64_t n = 0; n < count; ++n)
    geometry.corners[n] = indices ? indices->WholeAt(n) : static_cast<std::uint32_t>(n);
  return true;
}

bool ReadPlain(GltfBuffers& buffers,
               const JsonPlace& primitive,
               const GeometryWanted& wanted,
               PrimitiveGeometry& geometry) {
  const JsonPlace attributes = primitive["attributes"];
  const std::optional<GltfAccessor> positions = Values(buffers, attributes["POSITION"], 3, 3);
  if (!positions) {
    if (!attributes["POSITION"].exists()) attributes["POSITION"].Error("is missing");
    return false;
  }
  if (positions->count / 3 > wanted.max_faces) {
    attributes["POSITION"].Error("brings " + std::to_string(positions->count) +
                                 " vertices, too many");
    return false;
  }
  geometry.positions = Vectors<3>(*positions);
  if (wanted.texture_set >= 0) {
    const auto places = Values(buffers, attributes[PlacesName(wanted)], 2, 2);
    if (places && places->count == positions->count) geometry.places = Vectors<2>(*places);
  }
  if (wanted.colours) {
    const auto colours = Values(buffers, attributes["COLOR_0"], 3, 4);
    if (colours && colours->count == positions->count) geometry.colours = Vectors<3>(*colours);
  }
  return ReadCorners(buffers, primitive, wanted.max_faces, geometry);
}

DracoAttributeIds DracoIds(const JsonPlace& attributes, const GeometryWanted& wanted) {
  const auto id = [&](const std::string& attribute) {
    return attributes[attribute].Index(std::numeric_limits<int>::max());
  };
  DracoAttributeIds ids;
  ids.position = id("POSITION");
  if (wanted.texture_set >= 0) ids.place = id(PlacesName(wanted));
  if (wanted.colours) ids.colour = id("COLOR_0");
  ids.strict = wanted.strict;
  if (!wanted.strict) return ids;
  ids.normal = id("NORMAL");
  for (const std::string& name : attributes.Members()) {
    if (name != "POSITION" && name != "NORMAL") ids.others.push_back(id(name));
  }
  return ids;
}

bool ReadDraco(GltfBuffers& buffers,
               const JsonPlace& draco,
               const GeometryWanted& wanted,
               PrimitiveGeometry& geometry) {
  const std::optional<GltfView> view = buffers.View(draco["bufferView"]);
  if (!view) {
    if (!draco["bufferView"].exists()) draco["bufferView"].Error("is missing");
    return false;
  }
  Result<DracoMesh> mesh = DracoDecode(view->bytes, DracoIds(draco["attributes"], wanted));
  if (!mesh) {
    draco.Error(mesh.error().message);
    return false;
  }
  geometry.positions = std::move(mesh->positions);
  geometry.places = std::move(mesh->places);
  geometry.colours = std::move(mesh->colours);
  geometry.is_compressed = true;
  geometry.corners.reserve(3 * mesh->faces.size());
  for (const auto& face : mesh->faces)
    geometry.corners.insert(geometry.corners.end(), face.begin(), face.end());
  return true;
}

}  // namespace

JsonPlace DracoOf(const JsonPlace& primitive) { return primitive["extensions"][kDracoExtension]; }

std::optional<PrimitiveGeometry> ReadPrimitive(GltfBuffers& buffers,
                                               const JsonPlace& primitive,
                                               const GeometryWanted& wanted) {
  const std::size_t errors_before = primitive.num_errors();
  PrimitiveGeometry geometry;
  const JsonPlace draco = DracoOf(primitive);
  const bool is_read = draco.Members().empty() ? ReadPlain(buffers, primitive, wanted, geometry)
                                               : ReadDraco(buffers, draco, wanted, geometry);
  if (!is_read || primitive.num_errors() != errors_before) return std::nullopt;
  for (const std::uint32_t corner : geometry.corners) {
    if (corner < geometry.positions.size()) continue;
    primitive["indices"].Error("names vertex " + std::to_string(corner) + " of " +
                               std::to_string(geometry.positions.size()));
    return std::nullopt;
  }
  return geometry;
}

}  // namespace deepslam::gltf
