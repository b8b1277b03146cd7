#include "deepslam/gltf/glb_materials.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "deepslam/core/utf8.h"
#include "deepslam/gltf/render_mesh.h"

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_ENABLE_DRACO
#define TINYGLTF_NO_INCLUDE_JSON
#include <tiny_gltf.h>

namespace deepslam::gltf {
namespace {

constexpr double kRoughness = 0.8;  // furniture is matt more than it shines
constexpr const char* kVariants = "KHR_materials_variants";
constexpr int kAppearance = 0;   // places in the list of variants
constexpr int kClassColour = 1;  // flat, one for each class

}  // namespace

void UseExtension(const char* name, bool required, tinygltf::Model& model) {
  const auto add = [&](std::vector<std::string>& names) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.emplace_back(name);
  };
  add(model.extensionsUsed);
  if (required) add(model.extensionsRequired);
}

int GlbMaterials::Add(const std::string& name, Rgb8 colour, bool double_sided, double opacity) {
  return Add(name, {.base = colour, .double_sided = double_sided, .opacity = opacity});
}

int GlbMaterials::Add(const std::string& name, const Surface& surface) {
  const auto key =
      std::tuple(name, Key(surface.base), Key(surface.glow), surface.double_sided, surface.opacity);
  const auto found = of_surface_.find(key);
  if (found != of_surface_.end()) return found->second;
  const auto linear = [](Rgb8 c) {
    return std::vector<double>{LinearFromSrgb(c.r) / 65535.0,
                               LinearFromSrgb(c.g) / 65535.0,
                               LinearFromSrgb(c.b) / 65535.0};
  };
  tinygltf::Material material;
  material.name = ToValidUtf8(name);
  material.pbrMetallicRoughness.baseColorFactor = linear(surface.base);
  material.pbrMetallicRoughness.baseColorFactor.push_back(surface.opacity);
  material.pbrMetallicRoughness.metallicFactor = 0.0;
  material.pbrMetallicRoughness.roughnessFactor = kRoughness;
  material.emissiveFactor = linear(surface.glow);
  material.doubleSided = surface.double_sided;
  if (surface.opacity < 1) material.alphaMode = "BLEND";
  const int index = static_cast<int>(model_.materials.size());
  model_.materials.push_back(material);
  of_surface_[key] = index;
  return index;
}

// Vertex colours multiply the base colour in every material, so the class colour is one that
// glows: flat, as class colours of segmentations are.
void GlbMaterials::AddClassVariant(const std::string& name,
                                   Rgb8 class_colour,
                                   tinygltf::Primitive& primitive) {
  const int flat = Add(name + " (class colour)", {.base = {0, 0, 0}, .glow = class_colour});
  tinygltf::Value::Array mappings;
  for (const auto& [variant, material] :
       {std::pair(kAppearance, primitive.material), std::pair(kClassColour, flat)}) {
    tinygltf::Value::Object mapping;
    mapping["material"] = tinygltf::Value(material);
    mapping["variants"] = tinygltf::Value(tinygltf::Value::Array{tinygltf::Value(variant)});
    mappings.emplace_back(std::move(mapping));
  }
  tinygltf::Value::Object extension;
  extension["mappings"] = tinygltf::Value(std::move(mappings));
  primitive.extensions[kVariants] = tinygltf::Value(std::move(extension));
  UseExtension(kVariants, false, model_);
  if (model_.extensions.count(kVariants) != 0) return;
  tinygltf::Value::Array variants;
  for (const char* appearance : {"appearance", "class"}) {
    tinygltf::Value::Object variant;
    variant["name"] = tinygltf::Value(std::string(appearance));
    variants.emplace_back(std::move(variant));
  }
  tinygltf::Value::Object list;
  list["variants"] = tinygltf::Value(std::move(variants));
  model_.extensions[kVariants] = tinygltf::Value(std::move(list));
}

}  // namespace deepslam::gltf
