#include "deepslam/gltf/validate.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "deepslam/gltf/draco_mesh.h"
#include "deepslam/gltf/gltf_document.h"
#include "deepslam/gltf/tiny_gltf_check.h"
#include "deepslam/scene/mesh_check.h"

namespace deepslam::gltf {
namespace {

constexpr int kUnsignedByte = 5121;
constexpr int kUnsignedShort = 5123;
constexpr int kUnsignedInt = 5125;
constexpr int kFloat = 5126;
constexpr int kTriangles = 4;

// Geometry of one primitive as a reader gets it.
struct Geometry {
  std::vector<Eigen::Vector3f> positions;
  std::vector<std::uint32_t> indices;
};

// glTF's axes back to ours: its (x, y, z) is our (y, z, x).
Eigen::Vector3d FromGltfAxes(const Eigen::Vector3d& p) { return {p.z(), p.x(), p.y()}; }

Pose3 PoseOf(const GltfNode& node) {
  const auto& r = node.rotation;
  const auto& t = node.translation;
  return {Eigen::Quaterniond(r[3], r[2], r[0], r[1]).normalized(),
          FromGltfAxes({t[0], t[1], t[2]})};
}

Eigen::Vector3d SizeOf(const std::vector<Eigen::Vector3f>& points_gltf) {
  if (points_gltf.empty()) return Eigen::Vector3d::Zero();
  Eigen::Vector3f low = points_gltf.front();
  Eigen::Vector3f high = low;
  for (const Eigen::Vector3f& p : points_gltf) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return FromGltfAxes((high - low).cast<double>());
}

class Validator {
 public:
  Validator(const GltfDocument& document, Findings& findings, ValidationReport& report)
      : document_(document), findings_(findings), report_(report) {}

  void Run() {
    report_.num_nodes = static_cast<int>(document_.nodes.size());
    report_.num_meshes = static_cast<int>(document_.meshes.size());
    report_.num_cameras = document_.num_cameras;
    report_.variants = document_.variants;
    CheckTree();
    for (const GltfMesh& mesh : document_.meshes) {
      geometries_.emplace_back();
      for (const GltfPrimitive& primitive : mesh.primitives) {
        geometries_.back().push_back(ReadGeometry(primitive));
      }
    }
    CheckObjects();
  }

 private:
  // Every node has one parent at most, and none is its own ancestor.
  void CheckTree() {
    std::vector<int> parents(document_.nodes.size(), 0);
    for (std::size_t n = 0; n < document_.nodes.size(); ++n) {
      for (const int child : document_.nodes[n].children)
        ++parents[static_cast<std::size_t>(child)];
    }
    std::vector<int> pending;
    for (std::size_t n = 0; n < parents.size(); ++n) {
      if (parents[n] > 1) findings_.Error(NodePlace(n), "has several parents");
      if (parents[n] == 0) pending.push_back(static_cast<int>(n));
    }
    // What cannot be reached from a node without parent hangs in a cycle.
    std::size_t reached = 0;
    while (!pending.empty() && reached <= parents.size()) {
      const GltfNode& node = document_.nodes[static_cast<std::size_t>(pending.back())];
      pending.pop_back();
      ++reached;
      pending.insert(pending.end(), node.children.begin(), node.children.end());
    }
    if (findings_.errors.empty() && reached != parents.size()) {
      findings_.Error("nodes", "form a cycle");
    }
    for (const auto& roots : document_.scenes) {
      for (const int root : roots) {
        if (parents[static_cast<std::size_t>(root)] != 0) {
          findings_.Error(NodePlace(static_cast<std::size_t>(root)), "is a root and a child");
        }
      }
    }
  }

  static std::string NodePlace(std::size_t n) { return "nodes[" + std::to_string(n) + "]"; }

  std::optional<Geometry> ReadGeometry(const GltfPrimitive& primitive) {
    const std::size_t before = findings_.errors.size();
    const GltfAccessor* position = AttributeAccessor(primitive, "POSITION");
    if (position == nullptr) return std::nullopt;
    if (position->component_type != kFloat || position->num_components != 3) {
      findings_.Error(primitive.place + ".attributes.POSITION", "must be VEC3 of floats");
      return std::nullopt;
    }
    for (const auto& [name, index] : primitive.attributes) {
      const GltfAccessor* accessor = AttributeAccessor(primitive, name);
      if (accessor == nullptr) continue;
      if (accessor->count != position->count) {
        findings_.Error(primitive.place + ".attributes." + name,
                        std::to_string(accessor->count) + " values for " +
                            std::to_string(position->count) + " vertices");
      }
    }
    if (findings_.errors.size() != before) return std::nullopt;
    Geometry geometry;
    const bool ok = primitive.draco_view >= 0 ? ReadDraco(primitive, *position, geometry)
                                              : ReadPlain(primitive, *position, geometry);
    if (!ok) return std::nullopt;
    CheckGeometry(primitive, *position, geometry);
    if (findings_.errors.size() != before) return std::nullopt;
    if (primitive.mode == kTriangles) {
      report_.num_vertices += static_cast<std::int64_t>(geometry.positions.size());
      report_.num_faces += static_cast<std::int64_t>(geometry.indices.size() / 3);
    }
    return geometry;
  }

  const GltfAccessor* AttributeAccessor(const GltfPrimitive& primitive, const std::string& name) {
    const auto found = primitive.attributes.find(name);
    if (found == primitive.attributes.end() || found->second < 0) return nullptr;
    return &document_.accessors[static_cast<std::size_t>(found->second)];
  }

  [[nodiscard]] std::string_view ViewBytes(int view_index) const {
    const GltfView& view = document_.views[static_cast<std::size_t>(view_index)];
    return document_.binary.substr(view.offset, view.length);
  }

  bool ReadDraco(const GltfPrimitive& primitive, const GltfAccessor& position, Geometry& geometry) {
    report_.draco = true;
    const std::string place = primitive.place + ".extensions.KHR_draco_mesh_compression";
    if (primitive.mode != kTriangles || primitive.indices < 0) {
      findings_.Error(place, "needs triangles with indices");
      return false;
    }
    const auto id = [&](const char* name) {
      const auto found = primitive.draco_attributes.find(name);
      return found == primitive.draco_attributes.end() ? -1 : found->second;
    };
    const Result<RenderMesh> mesh =
        DracoDecodeForGltf(ViewBytes(primitive.draco_view), id("POSITION"), id("NORMAL"), -1);
    if (!mesh) {
      findings_.Error(place, mesh.error().message);
      return false;
    }
    const GltfAccessor& indices = document_.accessors[static_cast<std::size_t>(primitive.indices)];
    if (mesh->positions.size() != position.count || 3 * mesh->faces.size() != indices.count) {
      findings_.Error(place,
                      "decodes to " + std::to_string(mesh->positions.size()) + " vertices and " +
                          std::to_string(3 * mesh->faces.size()) + " indices, the accessors say " +
                          std::to_string(position.count) + " and " + std::to_string(indices.count));
      return false;
    }
    geometry.positions = mesh->positions;
    for (const auto& face : mesh->faces) {
      geometry.indices.insert(geometry.indices.end(), face.begin(), face.end());
    }
    return true;
  }

  bool ReadPlain(const GltfPrimitive& primitive, const GltfAccessor& position, Geometry& geometry) {
    for (const auto& [name, index] : primitive.attributes) {
      if (document_.accessors[static_cast<std::size_t>(index)].view < 0) {
        findings_.Error(primitive.place + ".attributes." + name, "accessor has no data");
        return false;
      }
    }
    const std::string_view bytes = ViewBytes(position.view);
    const std::uint64_t stride = std::max<std::uint64_t>(
        document_.views[static_cast<std::size_t>(position.view)].stride, 12);
    geometry.positions.resize(position.count);
    for (std::uint64_t n = 0; n < position.count; ++n) {
      std::memcpy(geometry.positions[n].data(), bytes.data() + position.offset + n * stride, 12);
    }
    if (primitive.indices >= 0) return ReadIndices(primitive, geometry);
    for (std::uint32_t n = 0; n < position.count; ++n) geometry.indices.push_back(n);
    return true;
  }

  bool ReadIndices(const GltfPrimitive& primitive, Geometry& geometry) {
    const GltfAccessor& accessor = document_.accessors[static_cast<std::size_t>(primitive.indices)];
    const bool known = accessor.component_type == kUnsignedByte ||
                       accessor.component_type == kUnsignedShort ||
                       accessor.component_type == kUnsignedInt;
    if (!known || accessor.num_components != 1 || accessor.view < 0 ||
        document_.views[static_cast<std::size_t>(accessor.view)].stride != 0) {
      findings_.Error(primitive.place + ".indices", "must be packed unsigned numbers with data");
      return false;
    }
    const std::string_view bytes = ViewBytes(accessor.view).substr(accessor.offset);
    const std::size_t width = static_cast<std::size_t>(accessor.component_bytes);
    geometry.indices.reserve(accessor.count);
    for (std::uint64_t n = 0; n < accessor.count; ++n) {
      std::uint32_t value = 0;
      std::memcpy(&value, bytes.data() + n * width, width);
      geometry.indices.push_back(value);
    }
    return true;
  }

  void CheckGeometry(const GltfPrimitive& primitive,
                     const GltfAccessor& position,
                     const Geometry& geometry) {
    const std::string place = primitive.place + ".attributes.POSITION";
    for (const Eigen::Vector3f& p : geometry.positions) {
      if (!p.allFinite()) {
        findings_.Error(place, "a vertex is not finite");
        return;
      }
    }
    Eigen::Vector3f low = geometry.positions.front();
    Eigen::Vector3f high = low;
    for (const Eigen::Vector3f& p : geometry.positions) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    const auto differs = [](const std::vector<double>& stated, const Eigen::Vector3f& true_value) {
      return stated.size() != 3 || static_cast<float>(stated[0]) != true_value.x() ||
             static_cast<float>(stated[1]) != true_value.y() ||
             static_cast<float>(stated[2]) != true_value.z();
    };
    if (differs(position.min, low) || differs(position.max, high)) {
      findings_.Error(place, "min and max are not those of the vertices");
    }
    if (primitive.mode == kTriangles && geometry.indices.size() % 3 != 0) {
      findings_.Error(primitive.place + ".indices", "no multiple of three");
    }
    for (const std::uint32_t index : geometry.indices) {
      if (index < geometry.positions.size()) continue;
      findings_.Error(primitive.place + ".indices",
                      "index " + std::to_string(index) + " of " +
                          std::to_string(geometry.positions.size()) + " vertices");
      return;
    }
  }

  void CheckObjects() {
    std::set<std::pair<std::string, std::int64_t>> labels;
    std::set<std::string> names;
    for (std::size_t n = 0; n < document_.nodes.size(); ++n) {
      const GltfNode& node = document_.nodes[n];
      report_.has_ground |= node.name == "ground" && node.mesh >= 0;
      report_.has_room |= node.name == "room" && node.mesh >= 0;
      report_.has_trajectory |= node.name == "trajectory" && node.mesh >= 0;
      if (!node.is_object) continue;
      const std::string place = NodePlace(n) + " '" + node.name + "'";
      ++report_.num_objects;
      if (node.name.empty()) findings_.Error(place, "an object without a name");
      if (!names.insert(node.name).second) findings_.Error(place, "name is not unique");
      if (node.class_name.empty() || !node.instance) {
        findings_.Error(place + ".extras", "class must be a text and instance a whole number");
        continue;
      }
      if (!labels.emplace(node.class_name, *node.instance).second) {
        findings_.Error(place + ".extras", "class and instance are not unique");
      }
      if (node.name.rfind(node.class_name, 0) != 0) {
        findings_.Warn(place, "name does not begin with its class " + node.class_name);
      }
      CheckObjectMesh(node, place);
    }
  }

  void CheckObjectMesh(const GltfNode& node, const std::string& place) {
    ValidatedObject object;
    object.name = node.name;
    object.class_name = node.class_name;
    object.instance = static_cast<int>(*node.instance);
    object.prior = node.prior;
    object.score = node.score;
    object.world_from_object = PoseOf(node);
    if (node.mesh < 0) {
      findings_.Warn(place, "object has no mesh");
      report_.objects.push_back(object);
      return;
    }
    TriangleMesh mesh;
    const Eigen::Vector3f scale =
        Eigen::Map<const Eigen::Vector3d>(node.scale.data()).cast<float>();
    for (const auto& geometry : geometries_[static_cast<std::size_t>(node.mesh)]) {
      if (!geometry) return;
      const std::uint32_t first = static_cast<std::uint32_t>(mesh.vertices.size());
      for (const Eigen::Vector3f& p : geometry->positions) {
        mesh.vertices.emplace_back(p.cwiseProduct(scale));
      }
      for (std::size_t n = 0; n + 2 < geometry->indices.size(); n += 3) {
        mesh.faces.push_back({first + geometry->indices[n],
                              first + geometry->indices[n + 1],
                              first + geometry->indices[n + 2]});
      }
    }
    object.size_m = SizeOf(mesh.vertices);
    const MeshCheck check = CheckMesh(mesh);
    if (!check.ok()) findings_.Error(place, "mesh is not closed and oriented: " + check.fault);
    object.num_faces = static_cast<int>(mesh.faces.size());
    std::set<std::array<float, 3>> places;
    for (const Eigen::Vector3f& p : mesh.vertices) places.insert({p.x(), p.y(), p.z()});
    object.num_vertices = static_cast<int>(places.size());
    object.num_components = check.num_components;
    object.volume_m3 = check.volume_m3;
    object.closed = check.closed && check.oriented;
    object.two_manifold = check.two_manifold;
    report_.objects.push_back(object);
  }

  const GltfDocument& document_;
  Findings& findings_;
  ValidationReport& report_;
  std::vector<std::vector<std::optional<Geometry>>> geometries_;
};

}  // namespace

ValidationReport ValidateGlb(std::string_view bytes) {
  ValidationReport report;
  report.num_bytes = bytes.size();
  Findings findings;
  try {
    const std::optional<GltfDocument> document = ReadGltfDocument(bytes, findings);
    if (document && findings.errors.empty()) Validator(*document, findings, report).Run();
    if (findings.errors.empty()) {
      // A second reader's opinion, on a file that has nothing left to hurt it with.
      const std::string refusal = LoadByTinyGltf(bytes);
      if (!refusal.empty()) findings.Warn("tinygltf", refusal);
    }
  } catch (const std::exception& e) {
    findings.Error("file", e.what());
  }
  report.errors = std::move(findings.errors);
  report.warnings = std::move(findings.warnings);
  return report;
}

}  // namespace deepslam::gltf
