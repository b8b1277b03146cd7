#include "deepslam/gltf/validate.h"

#include <algorithm>
#include <array>
#include <exception>
#include <optional>
#include <set>
#include <utility>

#include "deepslam/gltf/check_structure.h"
#include "deepslam/gltf/gltf_buffers.h"
#include "deepslam/gltf/gltf_document.h"
#include "deepslam/gltf/gltf_nodes.h"
#include "deepslam/gltf/primitive_geometry.h"
#include "deepslam/gltf/tiny_gltf_check.h"
#include "deepslam/shape/mesh_check.h"

namespace deepslam::gltf {
namespace {

// What a node says of the object it is.
struct Label {
  std::string class_name;
  std::optional<std::int64_t> instance;
  std::string prior;
  std::optional<double> score;
};

// Nothing where the node is none.
std::optional<Label> LabelOf(const JsonPlace& node) {
  const JsonPlace extras = node["extras"];
  if (!extras["class"].exists()) return std::nullopt;
  return Label{extras["class"].Text(),
               extras["instance"].MaybeWhole(),
               extras["prior"].Text(),
               extras["score"].MaybeNumber()};
}

// glTF's axes back to ours: its (x, y, z) is our (y, z, x).
Eigen::Vector3d FromGltfAxes(const Eigen::Vector3d& p) { return {p.z(), p.x(), p.y()}; }

Pose3 PoseOf(const GltfNode& node) {
  const Eigen::Quaterniond& r = node.rotation;
  return {Eigen::Quaterniond(r.w(), r.z(), r.x(), r.y()).normalized(),
          FromGltfAxes(node.translation)};
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
  Validator(const JsonPlace& root, GltfBuffers& buffers, ValidationReport& report)
      : root_(root), buffers_(buffers), report_(report) {}

  void Run() {
    const JsonPlace nodes = root_["nodes"];
    for (std::size_t n = 0; n < nodes.Size(); ++n) nodes_.push_back(ReadNode(root_, n));
    const JsonPlace meshes = root_["meshes"];
    report_.num_nodes = static_cast<int>(nodes_.size());
    report_.num_meshes = static_cast<int>(meshes.Size());
    report_.num_cameras = static_cast<int>(root_["cameras"].Size());
    report_.variants = VariantsOf(root_);
    CheckTree();
    for (std::size_t n = 0; n < meshes.Size(); ++n) {
      const JsonPlace primitives = meshes.At(n)["primitives"];
      geometries_.emplace_back();
      for (std::size_t p = 0; p < primitives.Size(); ++p)
        geometries_.back().push_back(ReadGeometry(primitives.At(p)));
    }
    CheckObjects();
  }

 private:
  // Every node has one parent at most, and none is its own ancestor.
  void CheckTree() {
    const JsonPlace nodes = root_["nodes"];
    std::vector<int> parents(nodes_.size(), 0);
    for (const GltfNode& node : nodes_) {
      for (const int child : node.children) ++parents[static_cast<std::size_t>(child)];
    }
    std::vector<int> pending;
    for (std::size_t n = 0; n < parents.size(); ++n) {
      if (parents[n] > 1) nodes.At(n).Error("has several parents");
      if (parents[n] == 0) pending.push_back(static_cast<int>(n));
    }
    // What cannot be reached from a node without parent hangs in a cycle.
    std::size_t reached = 0;
    while (!pending.empty() && reached <= parents.size()) {
      const GltfNode& node = nodes_[static_cast<std::size_t>(pending.back())];
      pending.pop_back();
      ++reached;
      pending.insert(pending.end(), node.children.begin(), node.children.end());
    }
    if (root_.num_errors() == 0 && reached != parents.size()) nodes.Error("form a cycle");
    const JsonPlace scenes = root_["scenes"];
    for (std::size_t s = 0; s < scenes.Size(); ++s) {
      for (const int node : scenes.At(s)["nodes"].Indices(nodes_.size())) {
        const auto n = static_cast<std::size_t>(node);
        if (parents[n] != 0) nodes.At(n).Error("is a root and a child");
      }
    }
  }

  std::optional<PrimitiveGeometry> ReadGeometry(const JsonPlace& primitive) {
    const std::size_t errors_before = root_.num_errors();
    const JsonPlace attributes = primitive["attributes"];
    const JsonPlace place = attributes["POSITION"];
    const std::optional<GltfAccessor> position = buffers_.Accessor(place);
    if (!position) return std::nullopt;
    if (position->component_type != kFloat || position->num_components != 3) {
      place.Error("must be VEC3 of floats");
      return std::nullopt;
    }
    const bool compressed = DracoOf(primitive).exists();
    for (const std::string& name : attributes.Members())
      CheckAttribute(attributes[name], *position, compressed);
    if (compressed &&
        (primitive["mode"].Whole(kTriangles) != kTriangles || !primitive["indices"].exists()))
      DracoOf(primitive).Error("needs triangles with indices");
    if (root_.num_errors() != errors_before) return std::nullopt;
    report_.draco |= compressed;
    const std::optional<PrimitiveGeometry> geometry =
        ReadPrimitive(buffers_, primitive, {.strict = true});
    if (!geometry) return std::nullopt;
    if (compressed) CheckCounts(primitive, *position, *geometry);
    if (root_.num_errors() != errors_before) return std::nullopt;
    CheckGeometry(primitive, *geometry);
    if (root_.num_errors() != errors_before) return std::nullopt;
    if (primitive["mode"].Whole(kTriangles) == kTriangles) {
      report_.num_vertices += static_cast<std::int64_t>(geometry->positions.size());
      report_.num_faces += static_cast<std::int64_t>(geometry->corners.size() / 3);
    }
    return geometry;
  }

  void CheckAttribute(const JsonPlace& place, const GltfAccessor& position, bool compressed) {
    const std::optional<GltfAccessor> accessor = buffers_.Accessor(place);
    if (!accessor) return;
    if (accessor->count != position.count) {
      place.Error("has " + std::to_string(accessor->count) + " values for " +
                  std::to_string(position.count) + " vertices");
    }
    if (!compressed && !accessor->has_data) place.Error("has no data");
  }

  // A decoder has to get what the accessors say.
  void CheckCounts(const JsonPlace& primitive,
                   const GltfAccessor& position,
                   const PrimitiveGeometry& geometry) {
    const std::optional<GltfAccessor> indices = buffers_.Accessor(primitive["indices"]);
    if (!indices ||
        (geometry.positions.size() == position.count && geometry.corners.size() == indices->count))
      return;
    DracoOf(primitive).Error("decodes to " + std::to_string(geometry.positions.size()) +
                             " vertices and " + std::to_string(geometry.corners.size()) +
                             " indices, the accessors say " + std::to_string(position.count) +
                             " and " + std::to_string(indices->count));
  }

  // Finite, and with the bounds that the accessor states.
  void CheckGeometry(const JsonPlace& primitive, const PrimitiveGeometry& geometry) {
    const JsonPlace place = primitive["attributes"]["POSITION"];
    Eigen::Vector3f low = geometry.positions.front();
    Eigen::Vector3f high = low;
    for (const Eigen::Vector3f& p : geometry.positions) {
      if (!p.allFinite()) return place.Error("a vertex is not finite");
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    const int number = place.Index(buffers_.num_accessors());
    const JsonPlace accessor = root_["accessors"].At(static_cast<std::size_t>(number));
    const auto differs = [](const JsonPlace& stated, const Eigen::Vector3f& true_value) {
      Eigen::Vector3d value;
      return !stated.Numbers({value.data(), 3}) || value.cast<float>() != true_value;
    };
    if (differs(accessor["min"], low) || differs(accessor["max"], high))
      place.Error("min and max are not those of the vertices");
    if (primitive["mode"].Whole(kTriangles) == kTriangles && geometry.corners.size() % 3 != 0)
      primitive["indices"].Error("no multiple of three");
  }

  void CheckObjects() {
    const JsonPlace places = root_["nodes"];
    std::set<std::pair<std::string, std::int64_t>> labels;
    std::set<std::string> names;
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      const GltfNode& node = nodes_[n];
      report_.has_ground |= node.name == "ground" && node.mesh >= 0;
      report_.has_room |= node.name == "room" && node.mesh >= 0;
      report_.has_trajectory |= node.name == "trajectory" && node.mesh >= 0;
      CheckPart(node, places.At(n).Named(node.name));
      const std::optional<Label> label = LabelOf(places.At(n));
      if (!label) continue;
      const JsonPlace place = places.At(n).Named(node.name);
      ++report_.num_objects;
      if (node.name.empty()) place.Error("an object without a name");
      if (!names.insert(node.name).second) place.Error("name is not unique");
      if (label->class_name.empty() || !label->instance) {
        place["extras"].Error("class must be a text and instance a whole number");
        continue;
      }
      if (!labels.emplace(label->class_name, *label->instance).second)
        place["extras"].Error("class and instance are not unique");
      if (node.name.rfind(label->class_name, 0) != 0)
        place.Warn("name does not begin with its class " + label->class_name);
      CheckObjectMesh(node, *label, place);
    }
  }

  // A wall, a door, a ceiling: named by its kind, and closed.
  void CheckPart(const GltfNode& node, const JsonPlace& place) {
    const JsonPlace extras = place["extras"];
    if (!extras["layout"].exists()) return;
    const std::string kind = extras["layout"].Text();
    const std::optional<std::int64_t> id = extras["id"].MaybeWhole();
    if (kind.empty() || !id) return extras.Error("layout must be a text and id a whole number");
    if (!parts_.emplace(kind, *id).second) return extras.Error("layout and id are not unique");
    if (node.name.rfind(kind, 0) != 0) place.Warn("name does not begin with its kind " + kind);
    report_.parts.push_back({node.name, kind, static_cast<int>(*id), node.mesh >= 0});
    if (node.mesh < 0) return;
    const std::optional<TriangleMesh> mesh = MeshOf(node);
    if (!mesh) return;
    const shape::MeshCheck check = shape::CheckMesh(*mesh);
    if (!check.ok()) place.Error("mesh is not closed and oriented: " + check.fault);
  }

  void CheckObjectMesh(const GltfNode& node, const Label& label, const JsonPlace& place) {
    ValidatedObject object;
    object.name = node.name;
    object.class_name = label.class_name;
    object.instance = static_cast<int>(*label.instance);
    object.prior = label.prior;
    object.score = label.score;
    object.world_from_object = PoseOf(node);
    if (node.mesh < 0) {
      place.Warn("object has no mesh");
      report_.objects.push_back(object);
      return;
    }
    const std::optional<TriangleMesh> mesh = MeshOf(node);
    if (!mesh) return;
    object.size_m = SizeOf(mesh->vertices);
    const shape::MeshCheck check = shape::CheckMesh(*mesh);
    if (!check.ok()) place.Error("mesh is not closed and oriented: " + check.fault);
    object.num_faces = static_cast<int>(mesh->faces.size());
    std::set<std::array<float, 3>> places;
    for (const Eigen::Vector3f& p : mesh->vertices) places.insert({p.x(), p.y(), p.z()});
    object.num_vertices = static_cast<int>(places.size());
    object.num_components = check.num_components;
    object.volume_m3 = check.volume_m3;
    object.closed = check.closed && check.oriented;
    object.two_manifold = check.two_manifold;
    report_.objects.push_back(object);
  }

  // Along the object's axes, glTF's; nothing where a primitive could not be read.
  [[nodiscard]] std::optional<TriangleMesh> MeshOf(const GltfNode& node) const {
    TriangleMesh mesh;
    const Eigen::Vector3f scale = node.scale.cast<float>();
    for (const auto& geometry : geometries_[static_cast<std::size_t>(node.mesh)]) {
      if (!geometry) return std::nullopt;
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      for (const Eigen::Vector3f& p : geometry->positions)
        mesh.vertices.emplace_back(p.cwiseProduct(scale));
      for (std::size_t n = 0; n + 2 < geometry->corners.size(); n += 3) {
        mesh.faces.push_back({first + geometry->corners[n],
                              first + geometry->corners[n + 1],
                              first + geometry->corners[n + 2]});
      }
    }
    return mesh;
  }

  JsonPlace root_;
  GltfBuffers& buffers_;
  ValidationReport& report_;
  std::vector<GltfNode> nodes_;
  std::set<std::pair<std::string, std::int64_t>> parts_;  // kind and id of those seen
  std::vector<std::vector<std::optional<PrimitiveGeometry>>> geometries_;  // of each mesh
};

}  // namespace

ValidationReport ValidateGlb(std::string_view bytes) {
  ValidationReport report;
  report.num_bytes = bytes.size();
  Findings findings;
  findings.strict = true;
  const ResourceLookup nothing_beside = [](const std::string&) { return std::nullopt; };
  try {
    if (const std::optional<GltfDocument> document = OpenGlb(bytes, findings)) {
      GltfBuffers buffers(document->root(), document->binary, nothing_beside);
      CheckStructure(document->root(), buffers);
      if (findings.ok()) Validator(document->root(), buffers, report).Run();
    }
    if (findings.ok()) {
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
