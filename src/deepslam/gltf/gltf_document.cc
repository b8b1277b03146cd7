#include "deepslam/gltf/gltf_document.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "deepslam/gltf/component_type.h"
#include "deepslam/gltf/glb_container.h"
#include "deepslam/gltf/validate.h"

namespace deepslam::gltf {
namespace {

using Json = nlohmann::json;

constexpr const char* kDraco = "KHR_draco_mesh_compression";
constexpr const char* kVariants = "KHR_materials_variants";
constexpr double kUnitTolerance = 1e-3;

std::string Indexed(const char* name, std::size_t n) {
  return std::string(name) + "[" + std::to_string(n) + "]";
}

int NumComponents(const std::string& type) {
  static const std::map<std::string, int> kTypes = {
      {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}};
  const auto found = kTypes.find(type);
  return found == kTypes.end() ? 0 : found->second;
}

class DocumentReader {
 public:
  DocumentReader(const Json& root, std::string_view binary, Findings& findings)
      : root_(root), binary_(binary), findings_(findings) {}

  GltfDocument Read() {
    ReadAsset();
    ReadBuffers();
    ForEach("bufferViews", [&](const Json& o, const std::string& p) { ReadView(o, p); });
    ForEach("accessors", [&](const Json& o, const std::string& p) { ReadAccessor(o, p); });
    num_materials_ = List("materials").size();
    ReadVariants();
    document_.num_cameras = static_cast<int>(List("cameras").size());
    ForEach("meshes", [&](const Json& o, const std::string& p) { ReadMesh(o, p); });
    num_nodes_ = List("nodes").size();
    ForEach("nodes", [&](const Json& o, const std::string& p) { ReadNode(o, p); });
    ForEach("scenes", [&](const Json& o, const std::string& p) {
      document_.scenes.push_back(Indices(o, "nodes", p, num_nodes_));
    });
    Index(root_, "scene", "scene", document_.scenes.size());
    return std::move(document_);
  }

 private:
  const Json& List(const char* name) {
    static const Json kEmpty = Json::array();
    const auto found = root_.find(name);
    if (found == root_.end()) return kEmpty;
    if (!found->is_array() || found->empty()) {
      findings_.Error(name, "must be an array that is not empty");
      return kEmpty;
    }
    return *found;
  }

  template <typename Visit>
  void ForEach(const char* name, Visit visit) {
    const Json& list = List(name);
    static const Json kEmptyObject = Json::object();
    for (std::size_t n = 0; n < list.size(); ++n) {
      const std::string place = Indexed(name, n);
      if (!list[n].is_object()) findings_.Error(place, "must be an object");
      visit(list[n].is_object() ? list[n] : kEmptyObject, place);
    }
  }

  // A whole number that is not negative; `fallback` when absent, an error and `fallback` when
  // something else.
  std::uint64_t Whole(const Json& object,
                      const char* name,
                      const std::string& place,
                      std::uint64_t fallback) {
    const auto found = object.find(name);
    if (found == object.end()) return fallback;
    if (found->is_number_unsigned()) return found->get<std::uint64_t>();
    findings_.Error(place + "." + name, "must be a whole number that is not negative");
    return fallback;
  }

  // An index below `size`; -1 when absent or wrong.
  int Index(const Json& object, const char* name, const std::string& place, std::size_t size) {
    if (object.find(name) == object.end()) return -1;
    constexpr std::uint64_t kWrong = std::numeric_limits<std::uint64_t>::max();
    const std::uint64_t value = Whole(object, name, place, kWrong);
    if (value == kWrong) return -1;
    if (value < size && value < std::numeric_limits<int>::max()) return static_cast<int>(value);
    findings_.Error(place + "." + name, std::to_string(value) + " of " + std::to_string(size));
    return -1;
  }

  std::vector<int> Indices(const Json& object,
                           const char* name,
                           const std::string& place,
                           std::size_t size) {
    std::vector<int> result;
    const auto found = object.find(name);
    if (found == object.end()) return result;
    if (!found->is_array() || found->empty()) {
      findings_.Error(place + "." + name, "must be an array that is not empty");
      return result;
    }
    for (const Json& entry : *found) {
      if (entry.is_number_unsigned() && entry.get<std::uint64_t>() < size) {
        result.push_back(static_cast<int>(entry.get<std::uint64_t>()));
      } else {
        findings_.Error(place + "." + name, "holds an index out of range");
      }
    }
    return result;
  }

  std::string Text(const Json& object, const char* name) {
    const auto found = object.find(name);
    return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
  }

  // Finite numbers; their count must be `size` where that is not 0.
  std::vector<double> Numbers(const Json& object,
                              const char* name,
                              const std::string& place,
                              std::size_t size) {
    std::vector<double> result;
    const auto found = object.find(name);
    if (found == object.end()) return result;
    if (found->is_array()) {
      for (const Json& entry : *found) {
        if (entry.is_number() && std::isfinite(entry.get<double>())) {
          result.push_back(entry.get<double>());
        }
      }
    }
    if (!found->is_array() || result.size() != found->size() ||
        (size != 0 && result.size() != size)) {
      findings_.Error(place + "." + name, "must be " + std::to_string(size) + " finite numbers");
      result.clear();
    }
    return result;
  }

  void ReadAsset() {
    const auto asset = root_.find("asset");
    if (asset == root_.end() || !asset->is_object() || Text(*asset, "version") != "2.0") {
      findings_.Error("asset.version", "must be \"2.0\"");
    }
    const auto required = root_.find("extensionsRequired");
    if (required == root_.end() || !required->is_array()) return;
    for (const Json& name : *required) {
      if (name == kDraco) {
        document_.requires_draco = true;
      } else {
        findings_.Error("extensionsRequired", name.dump(-1, ' ', true) + " is not supported");
      }
    }
  }

  void ReadBuffers() {
    const Json& buffers = List("buffers");
    if (buffers.empty()) return;
    if (buffers.size() > 1) findings_.Error("buffers", "only the GLB's own buffer is supported");
    if (!buffers[0].is_object()) {
      findings_.Error("buffers[0]", "must be an object");
      return;
    }
    if (buffers[0].contains("uri")) findings_.Error("buffers[0].uri", "external data");
    const std::uint64_t length = Whole(buffers[0], "byteLength", "buffers[0]", 0);
    if (length == 0 || length > binary_.size()) {
      findings_.Error(
          "buffers[0].byteLength",
          std::to_string(length) + " bytes, the BIN chunk has " + std::to_string(binary_.size()));
      return;
    }
    if (binary_.size() - length > 3) findings_.Warn("buffers[0].byteLength", "BIN chunk is longer");
    document_.binary = binary_.substr(0, length);
  }

  void ReadView(const Json& object, const std::string& place) {
    GltfView view;
    view.offset = Whole(object, "byteOffset", place, 0);
    view.length = Whole(object, "byteLength", place, 0);
    view.stride = Whole(object, "byteStride", place, 0);
    if (Index(object, "buffer", place, List("buffers").size()) != 0) {
      findings_.Error(place + ".buffer", "must be 0");
    }
    const std::uint64_t size = document_.binary.size();
    if (view.length == 0 || view.offset > size || view.length > size - view.offset) {
      findings_.Error(place,
                      "bytes " + std::to_string(view.offset) + " + " + std::to_string(view.length) +
                          " leave the buffer of " + std::to_string(size));
      view.offset = 0;
      view.length = 0;
    }
    if (object.contains("byteStride") &&
        (view.stride < 4 || view.stride > 252 || view.stride % 4 != 0)) {
      findings_.Error(place + ".byteStride", std::to_string(view.stride) + " is not allowed");
    }
    document_.views.push_back(view);
  }

  void ReadAccessor(const Json& object, const std::string& place) {
    GltfAccessor accessor;
    accessor.view = Index(object, "bufferView", place, document_.views.size());
    accessor.offset = Whole(object, "byteOffset", place, 0);
    accessor.count = Whole(object, "count", place, 0);
    accessor.component_type = static_cast<int>(
        std::min<std::uint64_t>(Whole(object, "componentType", place, 0), 1U << 16));
    accessor.component_bytes = ComponentBytes(static_cast<std::uint64_t>(accessor.component_type));
    accessor.num_components = NumComponents(Text(object, "type"));
    if (accessor.component_bytes == 0) findings_.Error(place + ".componentType", "unknown");
    if (accessor.num_components == 0) findings_.Error(place + ".type", "unknown");
    if (accessor.count == 0) findings_.Error(place + ".count", "must be 1 or more");
    if (object.contains("sparse")) findings_.Error(place + ".sparse", "is not supported");
    const std::size_t num_bounds = static_cast<std::size_t>(accessor.num_components);
    accessor.min = Numbers(object, "min", place, num_bounds);
    accessor.max = Numbers(object, "max", place, num_bounds);
    if (accessor.view >= 0 && accessor.component_bytes > 0 && accessor.num_components > 0) {
      CheckAccessorBounds(accessor, place);
    }
    document_.accessors.push_back(accessor);
  }

  void CheckAccessorBounds(const GltfAccessor& accessor, const std::string& place) {
    const GltfView& view = document_.views[static_cast<std::size_t>(accessor.view)];
    const std::uint64_t component = static_cast<std::uint64_t>(accessor.component_bytes);
    const std::uint64_t element = component * static_cast<std::uint64_t>(accessor.num_components);
    const std::uint64_t stride = view.stride == 0 ? element : view.stride;
    if (accessor.offset % component != 0 || (view.offset + accessor.offset) % component != 0) {
      findings_.Error(place + ".byteOffset", "not aligned to its component");
    }
    if (stride < element || stride % component != 0) {
      findings_.Error(place, "stride " + std::to_string(stride) + " does not fit its elements");
    }
    // Without overflow: every factor is bounded by the view before it is multiplied.
    const bool fits = accessor.offset <= view.length && element <= view.length - accessor.offset &&
                      accessor.count >= 1 &&
                      accessor.count - 1 <= (view.length - accessor.offset - element) / stride;
    if (!fits) {
      findings_.Error(place + ".count",
                      std::to_string(accessor.count) + " elements leave their buffer view");
    }
  }

  void ReadMesh(const Json& object, const std::string& place) {
    GltfMesh mesh;
    const auto primitives = object.find("primitives");
    if (primitives == object.end() || !primitives->is_array() || primitives->empty()) {
      findings_.Error(place + ".primitives", "must be an array that is not empty");
    } else {
      for (std::size_t n = 0; n < primitives->size(); ++n) {
        const std::string inner = place + "." + Indexed("primitives", n);
        if ((*primitives)[n].is_object()) {
          mesh.primitives.push_back(ReadPrimitive((*primitives)[n], inner));
        } else {
          findings_.Error(inner, "must be an object");
        }
      }
    }
    document_.meshes.push_back(std::move(mesh));
  }

  GltfPrimitive ReadPrimitive(const Json& object, const std::string& place) {
    GltfPrimitive primitive;
    primitive.place = place;
    primitive.indices = Index(object, "indices", place, document_.accessors.size());
    Index(object, "material", place, num_materials_);
    primitive.mode = static_cast<int>(std::min<std::uint64_t>(Whole(object, "mode", place, 4), 7));
    if (primitive.mode > 6) findings_.Error(place + ".mode", "unknown");
    const auto attributes = object.find("attributes");
    if (attributes != object.end() && attributes->is_object()) {
      for (const auto& entry : attributes->items()) {
        primitive.attributes[entry.key()] = Index(
            *attributes, entry.key().c_str(), place + ".attributes", document_.accessors.size());
      }
    }
    if (primitive.attributes.count("POSITION") == 0) {
      findings_.Error(place + ".attributes", "POSITION is missing");
    }
    const auto extensions = object.find("extensions");
    if (extensions != object.end() && extensions->is_object() && extensions->contains(kDraco)) {
      ReadDraco((*extensions)[kDraco], place + ".extensions." + kDraco, primitive);
    }
    if (extensions != object.end() && extensions->is_object() && extensions->contains(kVariants)) {
      CheckMappings((*extensions)[kVariants], place + ".extensions." + kVariants);
    }
    return primitive;
  }

  void ReadDraco(const Json& object, const std::string& place, GltfPrimitive& primitive) {
    if (!object.is_object()) {
      findings_.Error(place, "must be an object");
      return;
    }
    primitive.draco_view = Index(object, "bufferView", place, document_.views.size());
    if (primitive.draco_view < 0) findings_.Error(place + ".bufferView", "is missing or wrong");
    const auto attributes = object.find("attributes");
    if (attributes == object.end() || !attributes->is_object()) {
      findings_.Error(place + ".attributes", "is missing");
      return;
    }
    for (const auto& entry : attributes->items()) {
      if (primitive.attributes.count(entry.key()) == 0) {
        findings_.Error(place + ".attributes." + entry.key(),
                        "the primitive has no such attribute");
      }
      constexpr std::size_t kMaxId = std::numeric_limits<int>::max();
      primitive.draco_attributes[entry.key()] =
          Index(*attributes, entry.key().c_str(), place + ".attributes", kMaxId);
    }
  }

  // Names of the appearances a scene can be switched between.
  void ReadVariants() {
    const auto extensions = root_.find("extensions");
    if (extensions == root_.end() || !extensions->is_object() || !extensions->contains(kVariants)) {
      return;
    }
    const std::string place = std::string("extensions.") + kVariants + ".variants";
    const Json& object = (*extensions)[kVariants];
    const bool listed = object.is_object() && object.contains("variants") &&
                        object["variants"].is_array() && !object["variants"].empty();
    if (!listed) return findings_.Error(place, "must be an array that is not empty");
    for (const Json& variant : object["variants"]) {
      const std::string name = variant.is_object() ? Text(variant, "name") : std::string();
      if (name.empty()) findings_.Error(place, "a variant without a name");
      document_.variants.push_back(name);
    }
  }

  // A material for each variant, none named twice.
  void CheckMappings(const Json& object, const std::string& place) {
    const bool listed = object.is_object() && object.contains("mappings") &&
                        object["mappings"].is_array() && !object["mappings"].empty();
    if (!listed) return findings_.Error(place + ".mappings", "must be an array that is not empty");
    std::set<int> mapped;
    for (std::size_t n = 0; n < object["mappings"].size(); ++n) {
      const Json& mapping = object["mappings"][n];
      const std::string inner = place + "." + Indexed("mappings", n);
      if (!mapping.is_object()) {
        findings_.Error(inner, "must be an object");
        continue;
      }
      if (!mapping.contains("material")) findings_.Error(inner + ".material", "is missing");
      Index(mapping, "material", inner, num_materials_);
      for (const int variant : Indices(mapping, "variants", inner, document_.variants.size())) {
        if (!mapped.insert(variant).second) {
          findings_.Error(inner + ".variants", std::to_string(variant) + " stands twice");
        }
      }
    }
  }

  void ReadNode(const Json& object, const std::string& place) {
    GltfNode node;
    node.name = Text(object, "name");
    node.mesh = Index(object, "mesh", place, document_.meshes.size());
    node.camera = Index(object, "camera", place, static_cast<std::size_t>(document_.num_cameras));
    node.children = Indices(object, "children", place, num_nodes_);
    const std::vector<double> translation = Numbers(object, "translation", place, 3);
    std::copy(translation.begin(), translation.end(), node.translation.begin());
    Numbers(object, "matrix", place, 16);
    const std::vector<double> scale = Numbers(object, "scale", place, 3);
    for (std::size_t axis = 0; axis < scale.size(); ++axis) {
      if (scale[axis] == 0) findings_.Error(place + ".scale", "is zero");
      node.scale[axis] = scale[axis];
    }
    const std::vector<double> rotation = Numbers(object, "rotation", place, 4);
    std::copy(rotation.begin(), rotation.end(), node.rotation.begin());
    if (!rotation.empty()) {
      double squared = 0;
      for (const double value : rotation) squared += value * value;
      if (!(std::abs(std::sqrt(squared) - 1.0) < kUnitTolerance)) {
        findings_.Error(place + ".rotation", "is no unit quaternion");
      }
    }
    const auto extras = object.find("extras");
    if (extras != object.end() && extras->is_object() && extras->contains("class")) {
      node.is_object = true;
      node.class_name = Text(*extras, "class");
      const auto instance = extras->find("instance");
      if (instance != extras->end() && instance->is_number_integer()) {
        node.instance = instance->get<std::int64_t>();
      }
      node.prior = Text(*extras, "prior");
      const auto score = extras->find("score");
      if (score != extras->end() && score->is_number()) node.score = score->get<double>();
    }
    document_.nodes.push_back(std::move(node));
  }

  const Json& root_;
  std::string_view binary_;
  Findings& findings_;
  GltfDocument document_;
  std::size_t num_materials_ = 0;
  std::size_t num_nodes_ = 0;
};

}  // namespace

void Findings::Error(const std::string& place, const std::string& what) {
  if (errors.size() < kMaxFindings) errors.push_back(place + ": " + what);
}

void Findings::Warn(const std::string& place, const std::string& what) {
  if (warnings.size() < kMaxFindings) warnings.push_back(place + ": " + what);
}

std::optional<GltfDocument> ReadGltfDocument(std::string_view bytes, Findings& findings) {
  const std::optional<GlbChunks> chunks = ReadGlbChunks(bytes, findings);
  if (!chunks) return std::nullopt;
  if (const std::string fault = NestingFault(chunks->json); !fault.empty()) {
    findings.Error("JSON", fault);
    return std::nullopt;
  }
  const Json root = Json::parse(chunks->json.begin(), chunks->json.end(), nullptr, false);
  if (root.is_discarded() || !root.is_object()) {
    findings.Error("JSON", "cannot be parsed as an object");
    return std::nullopt;
  }
  return DocumentReader(root, chunks->binary, findings).Read();
}

}  // namespace deepslam::gltf
