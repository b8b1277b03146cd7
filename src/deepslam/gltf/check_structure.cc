#include "deepslam/gltf/check_structure.h"

#include <cstdint>
#include <limits>
#include <optional>
#include <set>

#include "deepslam/gltf/gltf_nodes.h"
#include "deepslam/gltf/primitive_geometry.h"

namespace deepslam::gltf {
namespace {

constexpr const char* kVariants = "KHR_materials_variants";
constexpr std::size_t kMostPadding = 3;  // bytes of a chunk behind its buffer

// Each element, which has to be an object.
template <typename Visitor>
void ForEach(const JsonPlace& list, Visitor visit) {
  const std::size_t size = list.Size();
  for (std::size_t n = 0; n < size; ++n) {
    if (!list.At(n).IsObject()) list.At(n).Error("must be an object");
    visit(list.At(n), n);
  }
}

class StructureCheck {
 public:
  StructureCheck(const JsonPlace& root, GltfBuffers& buffers)
      : root_(root),
        buffers_(buffers),
        num_materials_(root["materials"].Size()),
        num_variants_(VariantsOf(root).size()) {}

  void Run() {
    CheckExtensions();
    CheckBuffers();
    ForEach(root_["bufferViews"],
            [&](const JsonPlace&, std::size_t n) { (void)buffers_.ViewAt(n); });
    ForEach(root_["accessors"],
            [&](const JsonPlace& place, std::size_t n) { CheckAccessor(place, n); });
    ForEach(root_["meshes"], [&](const JsonPlace& place, std::size_t) {
      if (!place["primitives"].exists()) place["primitives"].Error("is missing");
      ForEach(place["primitives"],
              [&](const JsonPlace& primitive, std::size_t) { CheckPrimitive(primitive); });
    });
    const std::size_t num_cameras = root_["cameras"].Size();
    ForEach(root_["nodes"], [&](const JsonPlace& place, std::size_t n) {
      (void)ReadNode(root_, n);
      (void)place["camera"].Index(num_cameras);
    });
    const std::size_t num_nodes = root_["nodes"].Size();
    ForEach(root_["scenes"],
            [&](const JsonPlace& place, std::size_t) { (void)place["nodes"].Indices(num_nodes); });
    (void)root_["scene"].Index(root_["scenes"].Size());
  }

 private:
  void CheckExtensions() {
    const JsonPlace required = root_["extensionsRequired"];
    if (!required.exists()) return;
    for (std::size_t n = 0; n < required.Size(); ++n) {
      if (required.At(n).Text() != kDracoExtension)
        required.Error(required.At(n).Dump() + " is not supported");
    }
  }

  void CheckBuffers() {
    ForEach(root_["buffers"], [&](const JsonPlace& place, std::size_t n) {
      if (n > 0) return place.Error("only the GLB's own buffer is supported");
      if (place["uri"].exists()) return place["uri"].Error("external data");
      const std::optional<std::string_view> bytes = buffers_.BufferAt(0);
      if (bytes && buffers_.binary().size() - bytes->size() > kMostPadding)
        place["byteLength"].Warn("the BIN chunk is longer");
    });
  }

  void CheckAccessor(const JsonPlace& place, std::size_t n) {
    const std::optional<GltfAccessor> accessor = buffers_.AccessorAt(n);
    if (!accessor) return;
    std::vector<double> bounds(static_cast<std::size_t>(accessor->num_components));
    place["min"].Numbers(bounds);
    place["max"].Numbers(bounds);
  }

  void CheckPrimitive(const JsonPlace& place) {
    (void)place["indices"].Index(buffers_.num_accessors());
    (void)place["material"].Index(num_materials_);
    if (place["mode"].Whole(kTriangles) > kTriangleFan) place["mode"].Error("is unknown");
    const JsonPlace attributes = place["attributes"];
    for (const std::string& name : attributes.Members())
      (void)attributes[name].Index(buffers_.num_accessors());
    if (!attributes["POSITION"].exists()) attributes["POSITION"].Error("is missing");
    if (DracoOf(place).exists()) CheckDraco(place);
    const JsonPlace variants = place["extensions"][kVariants];
    if (variants.exists()) CheckMappings(variants["mappings"]);
  }

  void CheckDraco(const JsonPlace& primitive) {
    const JsonPlace draco = DracoOf(primitive);
    if (!draco.IsObject()) return draco.Error("must be an object");
    if (!draco["bufferView"].exists()) draco["bufferView"].Error("is missing");
    (void)draco["bufferView"].Index(buffers_.num_views());
    if (!draco["attributes"].IsObject()) return draco["attributes"].Error("is missing");
    for (const std::string& name : draco["attributes"].Members()) {
      const JsonPlace id = draco["attributes"][name];
      if (!primitive["attributes"][name].exists()) id.Error("the primitive has no such attribute");
      (void)id.Index(std::numeric_limits<int>::max());
    }
  }

  // A material for each variant, none named twice.
  void CheckMappings(const JsonPlace& mappings) {
    if (!mappings.exists()) return mappings.Error("is missing");
    std::set<int> mapped;
    ForEach(mappings, [&](const JsonPlace& mapping, std::size_t) {
      if (!mapping["material"].exists()) mapping["material"].Error("is missing");
      (void)mapping["material"].Index(num_materials_);
      for (const int variant : mapping["variants"].Indices(num_variants_)) {
        if (!mapped.insert(variant).second)
          mapping["variants"].Error(std::to_string(variant) + " stands twice");
      }
    });
  }

  JsonPlace root_;
  GltfBuffers& buffers_;
  std::size_t num_materials_ = 0;
  std::size_t num_variants_ = 0;
};

}  // namespace

void CheckStructure(const JsonPlace& root, GltfBuffers& buffers) {
  StructureCheck(root, buffers).Run();
}

std::vector<std::string> VariantsOf(const JsonPlace& root) {
  std::vector<std::string> names;
  const JsonPlace extension = root["extensions"][kVariants];
  if (!extension.exists()) return names;
  const JsonPlace variants = extension["variants"];
  if (!variants.exists()) variants.Error("is missing");
  ForEach(variants, [&](const JsonPlace& variant, std::size_t) {
    names.push_back(variant["name"].Text());
    if (names.back().empty()) variant["name"].Error("is missing");
  });
  return names;
}

}  // namespace deepslam::gltf
