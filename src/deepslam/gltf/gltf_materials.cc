#include "deepslam/gltf/gltf_materials.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

namespace deepslam::gltf {
namespace {

// From where on a surface is one that a depth camera does not measure: glass, and metal that
// mirrors.
constexpr float kClearAlpha = 0.6F;
constexpr float kClearTransmission = 0.4F;  // share of light; less is milky and does reflect
constexpr float kPolishedMetallic = 0.9F;  // 0 to 1: metal but for what a texture's noise takes off
constexpr float kPolishedRoughness = 0.15F;         // smoother metal mirrors instead of scattering
constexpr std::uint64_t kMaxTextureSet = 1U << 16;  // a number that no file has, which fits an int

float DisplayValue(float linear) {
  const float c = std::clamp(linear, 0.0F, 1.0F);
  return c <= 0.0031308F ? 12.92F * c : 1.055F * std::pow(c, 1 / 2.4F) - 0.055F;
}

Eigen::Vector2f ReadPair(const JsonPlace& place, double fallback) {
  std::array<double, 2> pair = {fallback, fallback};
  place.Numbers(pair);
  return {static_cast<float>(pair[0]), static_cast<float>(pair[1])};
}

TexturePlacement ReadPlacement(const JsonPlace& texture) {
  const JsonPlace moved = texture["extensions"]["KHR_texture_transform"];
  TexturePlacement placement;
  placement.offset = ReadPair(moved["offset"], 0);
  placement.scale = ReadPair(moved["scale"], 1);
  placement.rotation_rad = static_cast<float>(moved["rotation"].Number(0));
  const std::uint64_t set = texture["texCoord"].Whole(0);
  placement.set = static_cast<int>(std::min(moved["texCoord"].Whole(set), kMaxTextureSet));
  return placement;
}

class MaterialReader {
 public:
  MaterialReader(const JsonPlace& root, GltfBuffers& buffers) : root_(root), buffers_(buffers) {}

  void Read(const JsonPlace& place) {
    const JsonPlace pbr = place["pbrMetallicRoughness"];
    const JsonPlace glossy = place["extensions"]["KHR_materials_pbrSpecularGlossiness"];
    const bool is_glossy = pbr.Members().empty() && !glossy.Members().empty();
    std::array<double, 4> factor = {1, 1, 1, 1};
    (is_glossy ? glossy["diffuseFactor"] : pbr["baseColorFactor"]).Numbers(factor);
    SurfaceMaterial surface;
    surface.tint = DisplayFromLinear(Eigen::Vector3f(static_cast<float>(factor[0]),
                                                     static_cast<float>(factor[1]),
                                                     static_cast<float>(factor[2])));
    surface.diffuse = surface.tint;
    TexturePlacement placement;
    const JsonPlace texture = is_glossy ? glossy["diffuseTexture"] : pbr["baseColorTexture"];
    if (!texture.Members().empty()) {
      surface.texture = ReadTexture(texture);
      placement = ReadPlacement(texture);
    }
    surface.shiny = IsShiny(place, factor[3]);
    read.surfaces.push_back(surface);
    read.placements.push_back(placement);
  }

  GltfMaterials read;

 private:
  static bool IsShiny(const JsonPlace& place, double alpha) {
    const JsonPlace pbr = place["pbrMetallicRoughness"];
    const double metallic = pbr["metallicFactor"].Number(1);
    const double roughness = pbr["roughnessFactor"].Number(1);
    const double transmission =
        place["extensions"]["KHR_materials_transmission"]["transmissionFactor"].Number(0);
    const bool clear = place["alphaMode"].Text() == "BLEND" && alpha < kClearAlpha;
    const bool polished = metallic >= kPolishedMetallic && roughness <= kPolishedRoughness &&
                          !pbr.Members().empty() && !pbr["metallicRoughnessTexture"].exists();
    return clear || polished || transmission > kClearTransmission;
  }

  // Number in read.textures; -1 where there is none to be read.
  int ReadTexture(const JsonPlace& info) {
    const JsonPlace textures = root_["textures"];
    const int number = info["index"].Index(textures.Size());
    if (number < 0) return -1;
    const JsonPlace texture = textures.At(static_cast<std::size_t>(number));
    const JsonPlace images = root_["images"];
    int image = texture["source"].Index(images.Size());
    if (image < 0) image = texture["extensions"]["EXT_texture_webp"]["source"].Index(images.Size());
    if (image < 0) return -1;
    const auto [known, is_new] = textures_of_images_.try_emplace(image, -1);
    if (is_new) {
      std::optional<std::string> bytes = buffers_.Image(images.At(static_cast<std::size_t>(image)));
      if (bytes) {
        known->second = static_cast<int>(read.textures.size());
        read.textures.push_back(*std::move(bytes));
      }
    }
    return known->second;
  }

  JsonPlace root_;
  GltfBuffers& buffers_;
  std::map<int, int> textures_of_images_;
};

}  // namespace

Eigen::Vector2f TexturePlacement::operator()(const Eigen::Vector2f& uv) const {
  const Eigen::Vector2f s = scale.cwiseProduct(uv);
  const float cosine = std::cos(rotation_rad);
  const float sine = std::sin(rotation_rad);
  return {offset.x() + cosine * s.x() + sine * s.y(),
          1 - (offset.y() - sine * s.x() + cosine * s.y())};
}

GltfMaterials ReadMaterials(const JsonPlace& root, GltfBuffers& buffers) {
  MaterialReader reader(root, buffers);
  const JsonPlace materials = root["materials"];
  const std::size_t errors_before = root.num_errors();
  for (std::size_t m = 0; m < materials.Size() && root.num_errors() == errors_before; ++m)
    reader.Read(materials.At(m));
  return std::move(reader.read);
}

Eigen::Vector3f DisplayFromLinear(const Eigen::Vector3f& linear) {
  return {DisplayValue(linear.x()), DisplayValue(linear.y()), DisplayValue(linear.z())};
}

}  // namespace deepslam::gltf
