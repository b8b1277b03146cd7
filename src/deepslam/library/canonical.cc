#include "deepslam/library/canonical.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <utility>
#include <vector>

#include <tiny_obj_loader.h>

#include "deepslam/geometry/box.h"
#include "deepslam/library/classify.h"
#include "deepslam/shape/front.h"
#include "deepslam/shape/stretch.h"
#include "deepslam/shape/voxelize.h"

namespace deepslam::library {

Result<TriangleMesh> ReadObj(const std::string& obj_bytes) {
  tinyobj::attrib_t attributes;
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> materials;
  std::string warning;
  std::string error;
  std::istringstream stream(obj_bytes);
  if (!tinyobj::LoadObj(&attributes, &shapes, &materials, &warning, &error, &stream)) {
    return InvalidInput("not readable as OBJ: " + error);
  }
  TriangleMesh mesh;
  for (std::size_t n = 0; n + 2 < attributes.vertices.size(); n += 3) {
    mesh.vertices.emplace_back(
        attributes.vertices[n], attributes.vertices[n + 1], attributes.vertices[n + 2]);
  }
  for (const tinyobj::shape_t& shape : shapes) {
    const std::vector<tinyobj::index_t>& corners = shape.mesh.indices;
    for (std::size_t n = 0; n + 2 < corners.size(); n += 3) {
      std::array<std::uint32_t, 3> face{};
      bool usable = true;
      for (std::size_t c = 0; c < 3; ++c) {
        const int vertex = corners[n + c].vertex_index;
        usable = usable && vertex >= 0 && static_cast<std::size_t>(vertex) < mesh.vertices.size();
        face[c] = static_cast<std::uint32_t>(std::max(vertex, 0));
      }
      if (usable) mesh.faces.push_back(face);
    }
  }
  if (mesh.faces.empty()) return InvalidInput("OBJ without a usable face");
  return mesh;
}

Result<CanonicalModel> MakeCanonical(const TriangleMesh& mesh_file,
                                     const CatalogueItem& item,
                                     std::string_view class_name) {
  std::vector<Eigen::Vector3d> turned;
  turned.reserve(mesh_file.vertices.size());
  for (const Eigen::Vector3f& vertex : mesh_file.vertices) {
    turned.emplace_back(item.rotation * vertex.cast<double>());
  }
  Box3 box;
  for (const auto& face : mesh_file.faces) {
    for (const std::uint32_t n : face) box.Extend(turned[n]);
  }
  const Eigen::Vector3d extent = box.Size();
  constexpr double kFlatExtent = 1e-9;  // in the mesh's unit: nothing is divided by less
  if (!extent.allFinite() || extent.minCoeff() < kFlatExtent) return InvalidInput("mesh is flat");
  const Eigen::Vector3d size_file(item.width_m, item.height_m, item.depth_m);
  // A catalogue size of other proportions than the mesh means a wrong axis, not a stretched design.
  const Eigen::Array3d factors = size_file.array() / extent.array();
  // Rounded sizes and handles give less, an exchanged axis mostly more.
  constexpr double kMaxDistortion = 1.6;
  if (factors.maxCoeff() > kMaxDistortion * factors.minCoeff()) {
    return InvalidInput("catalogue size does not fit the mesh's proportions");
  }
  TriangleMesh mesh_object;
  mesh_object.faces = mesh_file.faces;
  for (const Eigen::Vector3d& vertex : turned) {
    const Eigen::Vector3d p = (vertex - box.Center()).array() * factors;
    mesh_object.vertices.emplace_back(Eigen::Vector3d(p.z(), p.x(), p.y()).cast<float>());
  }
  Result<VoxelGrid> shape = shape::Voxelize(mesh_object);
  if (!shape) return shape.error();
  CanonicalModel model = {std::move(*shape), {item.depth_m, item.width_m, item.height_m}, 0};
  const int turns = HasBack(class_name) ? shape::QuarterTurnsToFront(model.shape) : 0;
  model.quarter_turns = turns;
  model.shape = shape::TurnGrid(model.shape, turns);
  if (turns % 2 != 0) std::swap(model.size_m.x(), model.size_m.y());
  return model;
}

}  // namespace deepslam::library
