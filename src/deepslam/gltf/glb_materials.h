// The materials of a glTF file, each once, and the two appearances of coloured objects.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>

#include "deepslam/core/image.h"

namespace tinygltf {
class Model;
struct Primitive;
}  // namespace tinygltf

namespace deepslam::gltf {

using ColourKey = std::array<std::uint8_t, 3>;
[[nodiscard]] inline ColourKey Key(Rgb8 colour) { return {colour.r, colour.g, colour.b}; }

// Notes that the file uses an extension of this name, once.
void UseExtension(const char* name, bool required, tinygltf::Model& model);

// Adds to `model`, which outlives it.
class GlbMaterials {
 public:
  explicit GlbMaterials(tinygltf::Model& model) : model_(model) {}

  // The index of a rough material of that base colour (sRGB).
  int Add(const std::string& name, Rgb8 colour, bool double_sided, double opacity = 1);

  // A second appearance of a coloured primitive, by KHR_materials_variants: flat in that colour.
  void AddClassVariant(const std::string& name, Rgb8 class_colour, tinygltf::Primitive& primitive);

 private:
  struct Surface {
    Rgb8 base;
    Rgb8 glow{0, 0, 0};  // shown whatever light and vertex colours there are
    bool double_sided = false;
    double opacity = 1;
  };

  int Add(const std::string& name, const Surface& surface);

  tinygltf::Model& model_;
  std::map<std::tuple<std::string, ColourKey, ColourKey, bool, double>, int> of_surface_;
};

}  // namespace deepslam::gltf
