#include "deepslam/gltf/textured_model.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <deque>
#include <exception>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "deepslam/core/base64.h"
#include "deepslam/gltf/draco_mesh.h"
#include "deepslam/gltf/component_type.h"
#include "deepslam/gltf/glb_container.h"

namespace deepslam::gltf {
namespace {

using Json = nlohmann::json;

constexpr const char* kDraco = "KHR_draco_mesh_compression";
constexpr float kClearAlpha = 0.6F;
constexpr float kClearTransmission = 0.4F;
constexpr float kPolishedMetallic = 0.9F;
constexpr float kPolishedRoughness = 0.15F;

// Elements of an accessor, where its bytes lie.
struct ModelValues {
  const char* data = nullptr;
  std::uint64_t count = 0;
  std::uint64_t stride = 0;
  int component_type = 0;
  int component_bytes = 0;
  int num_components = 0;
  bool normalised = false;

  [[nodiscard]] float At(std::uint64_t n, int component) const {
    const char* at = Component(n, component);
    switch (component_type) {
      case 5120:
        return Scaled<std::int8_t>(at);
      case 5121:
        return Scaled<std::uint8_t>(at);
      case 5122:
        return Scaled<std::int16_t>(at);
      case 5123:
        return Scaled<std::uint16_t>(at);
      case 5125:
        return static_cast<float>(Read<std::uint32_t>(at));
      default:
        return Read<float>(at);
    }
  }
  // Of unsigned numbers.
  [[nodiscard]] std::uint32_t WholeAt(std::uint64_t n) const {
    const char* at = Component(n, 0);
    if (component_bytes == 1) return Read<std::uint8_t>(at);
    return component_bytes == 2 ? Read<std::uint16_t>(at) : Read<std::uint32_t>(at);
  }

 private:
  [[nodiscard]] const char* Component(std::uint64_t n, int component) const {
    return data + n * stride + static_cast<std::uint64_t>(component * component_bytes);
  }
  template <typename T>
  static T Read(const char* at) {
    T value;
    std::memcpy(&value, at, sizeof value);
    return value;
  }
  template <typename T>
  [[nodiscard]] float Scaled(const char* at) const {
    const auto value = static_cast<float>(Read<T>(at));
    return normalised ? std::max(value / static_cast<float>(std::numeric_limits<T>::max()), -1.0F)
                      : value;
  }
};

int NumComponents(const std::string& type) {
  static const std::map<std::string, int> kTypes = {
      {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}};
  const auto found = kTypes.find(type);
  return found == kTypes.end() ? 0 : found->second;
}

// %20 and its like.
std::string Unescaped(const std::string& uri) {
  std::string path;
  for (std::size_t n = 0; n < uri.size(); ++n) {
    const bool escaped = uri[n] == '%' && n + 2 < uri.size() &&
                         std::isxdigit(static_cast<unsigned char>(uri[n + 1])) != 0 &&
                         std::isxdigit(static_cast<unsigned char>(uri[n + 2])) != 0;
    path += escaped ? static_cast<char>(std::stoi(uri.substr(n + 1, 2), nullptr, 16)) : uri[n];
    if (escaped) n += 2;
  }
  return path;
}

// The values of a glTF's JSON and of its buffers, with every index and bound checked. The first
// fault is kept, after which answers are empty.
class ModelData {
 public:
  ModelData(const Json& root, std::string_view binary, const ResourceLookup& beside)
      : root_(root), binary_(binary), beside_(beside) {}

  [[nodiscard]] bool ok() const { return !fault_.has_value(); }
  [[nodiscard]] Error fault() const { return *fault_; }
  void Fail(const std::string& place, const std::string& what) {
    if (!fault_) fault_ = InvalidInput(place + " " + what);
  }

  // An object; an empty one where there is none.
  [[nodiscard]] const Json& Member(const Json& object, const char* name) const {
    static const Json kEmpty = Json::object();
    if (!object.is_object()) return kEmpty;
    const auto found = object.find(name);
    return found == object.end() || !found->is_object() ? kEmpty : *found;
  }
  const Json& List(const Json& object, const char* name) {
    static const Json kEmpty = Json::array();
    if (!object.is_object()) return kEmpty;
    const auto found = object.find(name);
    if (found == object.end()) return kEmpty;
    if (found->is_array()) return *found;
    Fail(name, "is no list");
    return kEmpty;
  }
  [[nodiscard]] std::string Text(const Json& object, const char* name) const {
    if (!object.is_object()) return {};
    const auto found = object.find(name);
    return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
  }
  std::uint64_t Whole(const Json& object,
                      const char* name,
                      const std::string& place,
                      std::uint64_t fallback) {
    if (!object.is_object()) return fallback;
    const auto found = object.find(name);
    if (found == object.end()) return fallback;
    if (found->is_number_unsigned()) return found->get<std::uint64_t>();
    Fail(place + "." + name, "is no whole number");
    return fallback;
  }
  // An index below `size`; -1 where there is none.
  int Index(const Json& object, const char* name, const std::string& place, std::size_t size) {
    constexpr std::uint64_t kNone = std::numeric_limits<std::uint64_t>::max();
    const std::uint64_t value = Whole(object, name, place, kNone);
    if (value == kNone) return -1;
    if (value < size && value < std::numeric_limits<int>::max()) return static_cast<int>(value);
    Fail(place + "." + name, "is " + std::to_string(value) + " of " + std::to_string(size));
    return -1;
  }
  std::vector<int> Indices(const Json& object,
                           const char* name,
                           const std::string& place,
                           std::size_t size) {
    std::vector<int> result;
    for (const Json& entry : List(object, name)) {
      if (!entry.is_number_unsigned() || entry.get<std::uint64_t>() >= size) {
        Fail(place + "." + name, "names what is not there");
        return {};
      }
      result.push_back(static_cast<int>(entry.get<std::uint64_t>()));
    }
    return result;
  }
  double Number(const Json& object, const char* name, const std::string& place, double fallback) {
    if (!object.is_object()) return fallback;
    const auto found = object.find(name);
    if (found == object.end()) return fallback;
    if (found->is_number() && std::isfinite(found->get<double>())) return found->get<double>();
    Fail(place + "." + name, "is no finite number");
    return fallback;
  }
  // Whether they are there.
  template <std::size_t N>
  bool Numbers(const Json& object,
               const char* name,
               const std::string& place,
               std::array<double, N>& values) {
    if (!object.is_object()) return false;
    const auto found = object.find(name);
    if (found == object.end()) return false;
    bool good = found->is_array() && found->size() == N;
    for (std::size_t n = 0; good && n < N; ++n) {
      good = (*found)[n].is_number() && std::isfinite((*found)[n].get<double>());
      if (good) values[n] = (*found)[n].get<double>();
    }
    if (!good) Fail(place + "." + name, "is no list of " + std::to_string(N) + " finite numbers");
    return good;
  }

  // Bytes of the buffer view that `object` names; nothing where it names none.
  std::optional<std::string_view> View(const Json& object,
                                       const char* name,
                                       const std::string& place) {
    const Json& views = List(root_, "bufferViews");
    const int number = Index(object, name, place, views.size());
    if (number < 0) return std::nullopt;
    const Json& view = views[static_cast<std::size_t>(number)];
    const std::string inner = "bufferViews[" + std::to_string(number) + "]";
    const int buffer = Index(view, "buffer", inner, List(root_, "buffers").size());
    if (buffer < 0) Fail(inner + ".buffer", "is missing");
    if (!ok()) return std::nullopt;
    const std::string_view bytes = Buffer(static_cast<std::size_t>(buffer));
    const std::uint64_t offset = Whole(view, "byteOffset", inner, 0);
    const std::uint64_t length = Whole(view, "byteLength", inner, 0);
    if (!ok()) return std::nullopt;
    if (offset > bytes.size() || length > bytes.size() - offset) {
      Fail(inner,
           "takes bytes " + std::to_string(offset) + " + " + std::to_string(length) + " of " +
               std::to_string(bytes.size()));
      return std::nullopt;
    }
    return bytes.substr(offset, length);
  }

  // Elements of the accessor that `object` names, of `low` to `high` components; nothing where it
  // names none.
  std::optional<ModelValues> Values(const Json& object,
                                    const char* name,
                                    const std::string& place,
                                    int low,
                                    int high) {
    const Json& accessors = List(root_, "accessors");
    const int number = Index(object, name, place, accessors.size());
    if (number < 0) return std::nullopt;
    const Json& accessor = accessors[static_cast<std::size_t>(number)];
    const std::string inner = "accessors[" + std::to_string(number) + "]";
    if (accessor.is_object() && accessor.contains("sparse"))
      Fail(inner + ".sparse", "is not supported; export without sparse accessors");
    const std::optional<std::string_view> view = View(accessor, "bufferView", inner);
    if (!view) Fail(inner, "has no data");
    ModelValues values;
    const std::uint64_t type = Whole(accessor, "componentType", inner, 0);
    values.component_bytes = ComponentBytes(type);
    values.num_components = NumComponents(Text(accessor, "type"));
    values.normalised = accessor.value("normalized", Json(false)) == Json(true);
    values.count = Whole(accessor, "count", inner, 0);
    if (values.component_bytes == 0) Fail(inner + ".componentType", "is unknown");
    if (values.num_components < low || values.num_components > high)
      Fail(inner + ".type", "is not what " + place + "." + name + " needs");
    if (high == 1 && (type == 5126 || type == 5120 || type == 5122))
      Fail(inner + ".componentType", "is no unsigned number");
    const std::uint64_t offset = Whole(accessor, "byteOffset", inner, 0);
    if (!ok()) return std::nullopt;
    values.component_type = static_cast<int>(type);
    const auto element =
        static_cast<std::uint64_t>(values.component_bytes * values.num_components);
    values.stride = Stride(accessor, element);
    const bool fits =
        values.count == 0 ||
        (offset <= view->size() && element <= view->size() - offset && values.stride >= element &&
         values.count - 1 <= (view->size() - offset - element) / values.stride);
    if (!fits) {
      Fail(inner + ".count",
           "says " + std::to_string(values.count) + " elements, more than its buffer view holds");
      return std::nullopt;
    }
    values.data = view->data() + offset;
    return values;
  }

  // Nothing where it is missing: textures are no reason to refuse a model.
  std::optional<std::string> ImageBytes(std::size_t number) {
    const Json& image = List(root_, "images")[number];
    if (image.is_object() && image.contains("bufferView")) {
      const auto bytes =
          View(image, "bufferView", "images[" + std::to_string(number) + "]");
      return bytes ? std::optional<std::string>(std::string(*bytes)) : std::nullopt;
    }
    const std::string uri = Text(image, "uri");
    return uri.empty() ? std::nullopt : Resource(uri);
  }

 private:
  // Of all buffers and textures together.
  static constexpr std::uint64_t kMaxBytes = std::uint64_t{1} << 30;

  std::uint64_t Stride(const Json& accessor, std::uint64_t element) {
    const Json& views = List(root_, "bufferViews");
    const int number = Index(accessor, "bufferView", "accessors", views.size());
    const std::uint64_t stride =
        Whole(views[static_cast<std::size_t>(number)], "byteStride", "bufferViews", 0);
    return stride == 0 ? element : stride;
  }

  std::optional<std::string> Resource(const std::string& uri) {
    if (uri.starts_with("data:")) {
      const std::size_t comma = uri.find(";base64,");
      if (comma == std::string::npos) return std::nullopt;
      Result<std::string> bytes = DecodeBase64(std::string_view(uri).substr(comma + 8));
      if (!bytes || !Afford(bytes->size())) return std::nullopt;
      return *std::move(bytes);
    }
    const std::string path = Unescaped(uri);
    const bool leads_away = path.starts_with('/') || path.find("..") != std::string::npos ||
                            path.find(':') != std::string::npos ||
                            path.find('\\') != std::string::npos ||
                            path.find('\0') != std::string::npos;
    if (leads_away) return std::nullopt;
    std::optional<std::string> bytes = beside_(path);
    if (bytes && !Afford(bytes->size())) return std::nullopt;
    return bytes;
  }

  bool Afford(std::uint64_t size) {
    num_bytes_ += size;
    if (num_bytes_ > kMaxBytes) Fail("buffers", "and textures hold more than 1 GiB");
    return num_bytes_ <= kMaxBytes;
  }

  std::string_view Buffer(std::size_t number) {
    const auto known = buffers_.find(number);
    if (known != buffers_.end()) return known->second;
    const std::string place = "buffers[" + std::to_string(number) + "]";
    const Json& buffer = List(root_, "buffers")[number];
    const std::uint64_t length = Whole(buffer, "byteLength", place, 0);
    const std::string uri = Text(buffer, "uri");
    std::string_view bytes = binary_;
    if (!uri.empty()) {
      std::optional<std::string> read = Resource(uri);
      if (!read) {
        Fail(place + ".uri",
             "'" + uri.substr(0, 80) +
                 "' cannot be read; put that file beside the model, or export as .glb");
        return {};
      }
      bytes = storage_.emplace_back(*std::move(read));
    }
    if (bytes.size() < length) {
      Fail(place + ".byteLength",
           "says " + std::to_string(length) + " bytes, there are " + std::to_string(bytes.size()) +
               ": is the file cut off?");
      return {};
    }
    return buffers_[number] = bytes.substr(0, length);
  }

  const Json& root_;
  std::string_view binary_;
  const ResourceLookup& beside_;
  std::deque<std::string> storage_;
  std::map<std::size_t, std::string_view> buffers_;
  std::uint64_t num_bytes_ = 0;
  std::optional<Error> fault_;
};

// What may be required of a reader and changes nothing of what is read here, or is read.
bool IsKnownExtension(const std::string& name) {
  static const std::vector<std::string> kKnown = {kDraco,
                                                  "KHR_mesh_quantization",
                                                  "KHR_lights_punctual",
                                                  "KHR_node_visibility",
                                                  "KHR_xmp_json_ld",
                                                  "EXT_texture_webp"};
  return std::find(kKnown.begin(), kKnown.end(), name) != kKnown.end() ||
         name.starts_with("KHR_materials_") || name.starts_with("KHR_texture_");
}

float DisplayFromLinear(float linear) {
  const float c = std::clamp(linear, 0.0F, 1.0F);
  return c <= 0.0031308F ? 12.92F * c : 1.055F * std::pow(c, 1 / 2.4F) - 0.055F;
}

Eigen::Vector3f DisplayFromLinear(const Eigen::Vector3f& linear) {
  return {
      DisplayFromLinear(linear.x()), DisplayFromLinear(linear.y()), DisplayFromLinear(linear.z())};
}

// How a texture is laid on: which of the mesh's coordinates, and KHR_texture_transform.
struct TexturePlace {
  int set = 0;
  Eigen::Vector2f offset = Eigen::Vector2f::Zero();
  Eigen::Vector2f scale = Eigen::Vector2f::Ones();
  float rotation_rad = 0;

  // From glTF's place, whose v runs downwards, to one whose v runs upwards.
  [[nodiscard]] Eigen::Vector2f operator()(const Eigen::Vector2f& uv) const {
    const Eigen::Vector2f s = scale.cwiseProduct(uv);
    const float cosine = std::cos(rotation_rad);
    const float sine = std::sin(rotation_rad);
    return {offset.x() + cosine * s.x() + sine * s.y(),
            1 - (offset.y() - sine * s.x() + cosine * s.y())};
  }
};

// One primitive before its node moves it.
struct Piece {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector2f> places;   // glTF's; or empty
  std::vector<Eigen::Vector3f> colours;  // linear; or empty
  std::vector<std::array<std::uint32_t, 3>> faces;
  int material = -1;
};

class ModelReader {
 public:
  ModelReader(const Json& root,
              std::string_view binary,
              const ResourceLookup& beside,
              std::size_t max_faces)
      : root_(root), max_faces_(max_faces), data_(root, binary, beside) {}

  Result<TexturedMesh> Read() {
    CheckHeader();
    ReadMaterials();
    if (!data_.ok()) return data_.fault();
    ReadScene();
    if (!data_.ok()) return data_.fault();
    if (mesh_.faces.empty())
      return InvalidInput("has no triangles in its scene; export the furniture as a mesh");
    if (!has_colours_) mesh_.colours.clear();
    return std::move(mesh_);
  }

 private:
  void CheckHeader() {
    const std::string version = data_.Text(data_.Member(root_, "asset"), "version");
    if (!version.starts_with("2."))
      data_.Fail("asset.version", "is '" + version + "', expected 2.0; export as glTF 2.0");
    for (const Json& name : data_.List(root_, "extensionsRequired")) {
      if (!name.is_string() || !IsKnownExtension(name.get<std::string>())) {
        data_.Fail("extensionsRequired",
                   name.dump(-1, ' ', true) + " is not supported; export without it");
      }
    }
  }

  void ReadMaterials() {
    const Json& materials = data_.List(root_, "materials");
    for (std::size_t m = 0; m < materials.size() && data_.ok(); ++m) {
      const std::string place = "materials[" + std::to_string(m) + "]";
      places_.emplace_back();
      mesh_.materials.push_back(ReadMaterial(materials[m], place, places_.back()));
    }
  }

  SurfaceMaterial ReadMaterial(const Json& from, const std::string& place, TexturePlace& laid) {
    const Json& pbr = data_.Member(from, "pbrMetallicRoughness");
    const Json& extensions = data_.Member(from, "extensions");
    const Json& glossy = data_.Member(extensions, "KHR_materials_pbrSpecularGlossiness");
    const bool is_glossy = pbr.empty() && !glossy.empty();
    const Json& source = is_glossy ? glossy : pbr;
    std::array<double, 4> factor = {1, 1, 1, 1};
    data_.Numbers(source, is_glossy ? "diffuseFactor" : "baseColorFactor", place, factor);
    SurfaceMaterial material;
    material.tint = DisplayFromLinear(Eigen::Vector3f(static_cast<float>(factor[0]),
                                                      static_cast<float>(factor[1]),
                                                      static_cast<float>(factor[2])));
    material.diffuse = material.tint;
    const Json& texture = data_.Member(source, is_glossy ? "diffuseTexture" : "baseColorTexture");
    if (!texture.empty()) {
      material.texture = ReadTexture(texture, place);
      laid = ReadPlace(texture, place);
    }
    const double metallic = data_.Number(pbr, "metallicFactor", place, 1);
    const double roughness = data_.Number(pbr, "roughnessFactor", place, 1);
    const double transmission = data_.Number(
        data_.Member(extensions, "KHR_materials_transmission"), "transmissionFactor", place, 0);
    const bool clear = data_.Text(from, "alphaMode") == "BLEND" && factor[3] < kClearAlpha;
    const bool polished = metallic >= kPolishedMetallic && roughness <= kPolishedRoughness &&
                          !pbr.empty() && !pbr.contains("metallicRoughnessTexture");
    material.shiny = clear || polished || transmission > kClearTransmission;
    return material;
  }

  TexturePlace ReadPlace(const Json& texture, const std::string& place) {
    TexturePlace laid;
    const Json& moved =
        data_.Member(data_.Member(texture, "extensions"), "KHR_texture_transform");
    std::array<double, 2> offset = {0, 0};
    std::array<double, 2> scale = {1, 1};
    data_.Numbers(moved, "offset", place, offset);
    data_.Numbers(moved, "scale", place, scale);
    laid.offset = {static_cast<float>(offset[0]), static_cast<float>(offset[1])};
    laid.scale = {static_cast<float>(scale[0]), static_cast<float>(scale[1])};
    laid.rotation_rad = static_cast<float>(data_.Number(moved, "rotation", place, 0));
    const std::uint64_t set = data_.Whole(texture, "texCoord", place, 0);
    laid.set = static_cast<int>(std::min<std::uint64_t>(
        data_.Whole(moved, "texCoord", place, set), 1U << 16));
    return laid;
  }

  // Number in mesh_.textures; -1 where there is none to be read.
  int ReadTexture(const Json& info, const std::string& place) {
    const Json& textures = data_.List(root_, "textures");
    const int number = data_.Index(info, "index", place, textures.size());
    if (number < 0) return -1;
    const Json& texture = textures[static_cast<std::size_t>(number)];
    const Json& images = data_.List(root_, "images");
    const std::string inner = "textures[" + std::to_string(number) + "]";
    int image = data_.Index(texture, "source", inner, images.size());
    if (image < 0) {
      const Json& webp = data_.Member(data_.Member(texture, "extensions"), "EXT_texture_webp");
      image = data_.Index(webp, "source", inner, images.size());
    }
    if (image < 0) return -1;
    const auto [known, is_new] = textures_of_images_.try_emplace(image, -1);
    if (is_new) {
      std::optional<std::string> bytes = data_.ImageBytes(static_cast<std::size_t>(image));
      if (bytes) {
        known->second = static_cast<int>(mesh_.textures.size());
        mesh_.textures.push_back(*std::move(bytes));
      }
    }
    return known->second;
  }

  void ReadScene() {
    const Json& nodes = data_.List(root_, "nodes");
    std::vector<std::pair<int, Eigen::Affine3d>> pending;
    for (const int root : Roots(nodes)) pending.emplace_back(root, Eigen::Affine3d::Identity());
    std::vector<bool> visited(nodes.size(), false);
    while (!pending.empty() && data_.ok()) {
      const auto [n, scene_from_parent] = pending.back();
      pending.pop_back();
      const std::string place = "nodes[" + std::to_string(n) + "]";
      if (visited[static_cast<std::size_t>(n)]) {
        data_.Fail(place, "has several parents, or is its own");
        return;
      }
      visited[static_cast<std::size_t>(n)] = true;
      const Json& node = nodes[static_cast<std::size_t>(n)];
      const Eigen::Affine3d scene_from_node = scene_from_parent * LocalTransform(node, place);
      for (const int child : data_.Indices(node, "children", place, nodes.size()))
        pending.emplace_back(child, scene_from_node);
      const Json& meshes = data_.List(root_, "meshes");
      const int mesh = data_.Index(node, "mesh", place, meshes.size());
      if (mesh >= 0) AddMesh(meshes[static_cast<std::size_t>(mesh)], mesh, scene_from_node);
    }
  }

  std::vector<int> Roots(const Json& nodes) {
    const Json& scenes = data_.List(root_, "scenes");
    if (!scenes.empty()) {
      const int chosen = data_.Index(root_, "scene", "scene", scenes.size());
      const auto s = static_cast<std::size_t>(std::max(chosen, 0));
      return data_.Indices(scenes[s], "nodes", "scenes[" + std::to_string(s) + "]", nodes.size());
    }
    std::vector<bool> is_child(nodes.size(), false);
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      const std::string place = "nodes[" + std::to_string(n) + "]";
      for (const int child : data_.Indices(nodes[n], "children", place, nodes.size()))
        is_child[static_cast<std::size_t>(child)] = true;
    }
    std::vector<int> roots;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      if (!is_child[n]) roots.push_back(static_cast<int>(n));
    }
    return roots;
  }

  Eigen::Affine3d LocalTransform(const Json& node, const std::string& place) {
    Eigen::Affine3d local = Eigen::Affine3d::Identity();
    std::array<double, 16> matrix{};
    if (data_.Numbers(node, "matrix", place, matrix)) {
      local.matrix() = Eigen::Map<const Eigen::Matrix4d>(matrix.data());  // both by columns
      local.makeAffine();
      return local;
    }
    std::array<double, 3> translation = {0, 0, 0};
    std::array<double, 4> rotation_xyzw = {0, 0, 0, 1};
    std::array<double, 3> scale = {1, 1, 1};
    data_.Numbers(node, "translation", place, translation);
    data_.Numbers(node, "rotation", place, rotation_xyzw);
    data_.Numbers(node, "scale", place, scale);
    const Eigen::Quaterniond q(
        rotation_xyzw[3], rotation_xyzw[0], rotation_xyzw[1], rotation_xyzw[2]);
    if (!(q.norm() > 0.5 && q.norm() < 2)) data_.Fail(place + ".rotation", "is no unit quaternion");
    local.translate(Eigen::Map<const Eigen::Vector3d>(translation.data()));
    local.rotate(q.normalized());
    local.scale(Eigen::Map<const Eigen::Vector3d>(scale.data()));
    return local;
  }

  void AddMesh(const Json& mesh, int number, const Eigen::Affine3d& scene_from_node) {
    const Json& primitives = data_.List(mesh, "primitives");
    for (std::size_t p = 0; p < primitives.size() && data_.ok(); ++p) {
      const std::string place =
          "meshes[" + std::to_string(number) + "].primitives[" + std::to_string(p) + "]";
      if (std::optional<Piece> piece = ReadPiece(primitives[p], place))
        AddPiece(*piece, scene_from_node);
    }
  }

  std::optional<Piece> ReadPiece(const Json& from, const std::string& place) {
    constexpr std::uint64_t kTriangles = 4;
    constexpr std::uint64_t kFan = 6;
    const std::uint64_t mode = data_.Whole(from, "mode", place, kTriangles);
    if (mode < kTriangles) return std::nullopt;  // points, lines
    if (mode > kFan) {
      data_.Fail(place + ".mode", std::to_string(mode) + " is unknown");
      return std::nullopt;
    }
    Piece piece;
    piece.material = data_.Index(from, "material", place, mesh_.materials.size());
    const Json& draco = data_.Member(data_.Member(from, "extensions"), kDraco);
    if (draco.empty()) {
      ReadPlain(from, place, mode, piece);
    } else {
      ReadDraco(draco, place, piece);
    }
    for (const auto& face : piece.faces) {
      for (const std::uint32_t corner : face) {
        if (corner < piece.positions.size()) continue;
        data_.Fail(place + ".indices",
                   "names vertex " + std::to_string(corner) + " of " +
                       std::to_string(piece.positions.size()));
        return std::nullopt;
      }
    }
    const std::size_t num_faces = mesh_.faces.size() + piece.faces.size();
    const std::size_t num_vertices = mesh_.vertices.size() + piece.positions.size();
    if (num_faces > max_faces_ || num_vertices > 3 * max_faces_) {
      data_.Fail(place,
                 "brings the model to " + std::to_string(std::max(num_faces, num_vertices / 3)) +
                     " faces, more than " + std::to_string(max_faces_) +
                     "; make it coarser (Blender: Decimate)");
    }
    return data_.ok() ? std::optional<Piece>(std::move(piece)) : std::nullopt;
  }

  [[nodiscard]] std::string TextureSet(const Piece& piece) const {
    const int set = piece.material < 0 ? 0 : places_[static_cast<std::size_t>(piece.material)].set;
    return "TEXCOORD_" + std::to_string(set);
  }

  void ReadPlain(const Json& from, const std::string& place, std::uint64_t mode, Piece& piece) {
    const Json& attributes = data_.Member(from, "attributes");
    const std::string inner = place + ".attributes";
    const std::optional<ModelValues> positions = data_.Values(attributes, "POSITION", inner, 3, 3);
    if (!positions) {
      data_.Fail(inner + ".POSITION", "is missing");
      return;
    }
    const std::uint64_t count = positions->count;
    if (count / 3 > max_faces_) {
      data_.Fail(inner + ".POSITION", std::to_string(count) + " vertices are too many");
      return;
    }
    for (std::uint64_t n = 0; n < count; ++n)
      piece.positions.emplace_back(positions->At(n, 0), positions->At(n, 1), positions->At(n, 2));
    const auto places = data_.Values(attributes, TextureSet(piece).c_str(), inner, 2, 2);
    if (places && places->count == count) {
      for (std::uint64_t n = 0; n < count; ++n)
        piece.places.emplace_back(places->At(n, 0), places->At(n, 1));
    }
    const auto colours = data_.Values(attributes, "COLOR_0", inner, 3, 4);
    if (colours && colours->count == count) {
      for (std::uint64_t n = 0; n < count; ++n)
        piece.colours.emplace_back(colours->At(n, 0), colours->At(n, 1), colours->At(n, 2));
    }
    const std::optional<ModelValues> indices = data_.Values(from, "indices", place, 1, 1);
    if (!data_.ok()) return;
    const std::uint64_t num_corners = indices ? indices->count : count;
    if (num_corners / 3 > max_faces_) {
      data_.Fail(place + ".indices", std::to_string(num_corners) + " corners are too many");
      return;
    }
    AddFaces(num_corners, mode, indices, piece);
  }

  // Strips turn every second triangle round; fans share their first corner.
  static void AddFaces(std::uint64_t num_corners,
                       std::uint64_t mode,
                       const std::optional<ModelValues>& indices,
                       Piece& piece) {
    const auto corner = [&](std::uint64_t n) {
      return indices ? indices->WholeAt(n) : static_cast<std::uint32_t>(n);
    };
    const std::uint64_t step = mode == 4 ? 3 : 1;
    for (std::uint64_t n = 0; n + 2 < num_corners; n += step) {
      std::array<std::uint32_t, 3> face = {corner(n), corner(n + 1), corner(n + 2)};
      if (mode == 5 && n % 2 == 1) std::swap(face[0], face[1]);
      if (mode == 6) face[0] = corner(0);
      if (face[0] != face[1] && face[1] != face[2] && face[2] != face[0])
        piece.faces.push_back(face);
    }
  }

  void ReadDraco(const Json& draco, const std::string& place, Piece& piece) {
    const std::string inner = place + ".extensions." + kDraco;
    const std::optional<std::string_view> bytes = data_.View(draco, "bufferView", inner);
    if (!bytes) {
      data_.Fail(inner + ".bufferView", "is missing");
      return;
    }
    const Json& attributes = data_.Member(draco, "attributes");
    const auto id = [&](const std::string& name) {
      return data_.Index(attributes, name.c_str(), inner, std::numeric_limits<int>::max());
    };
    const DracoAttributeIds ids = {id("POSITION"), id(TextureSet(piece)), id("COLOR_0")};
    if (!data_.ok()) return;
    Result<DracoModel> model = DracoDecodeModel(*bytes, ids);
    if (!model) {
      data_.Fail(inner, model.error().message);
      return;
    }
    piece.positions = std::move(model->positions);
    piece.places = std::move(model->places);
    piece.colours = std::move(model->colours);
    piece.faces = std::move(model->faces);
  }

  void AddPiece(const Piece& piece, const Eigen::Affine3d& scene_from_node) {
    const auto first = static_cast<std::uint32_t>(mesh_.vertices.size());
    for (const Eigen::Vector3f& p : piece.positions)
      mesh_.vertices.push_back(scene_from_node * p.cast<double>());
    has_colours_ |= !piece.colours.empty();
    for (const Eigen::Vector3f& c : piece.colours)
      mesh_.colours.push_back(DisplayFromLinear(c));
    mesh_.colours.resize(mesh_.vertices.size(), Eigen::Vector3f::Ones());
    const bool mirrored = scene_from_node.linear().determinant() < 0;
    const TexturePlace laid = piece.material < 0
                                  ? TexturePlace()
                                  : places_[static_cast<std::size_t>(piece.material)];
    for (const auto& corners : piece.faces) {
      TexturedMesh::Face face;
      face.material = piece.material;
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t corner = corners[mirrored ? 2 - c : c];
        face.vertices[c] = first + corner;
        if (!piece.places.empty()) face.places[c] = laid(piece.places[corner]);
      }
      mesh_.faces.push_back(face);
    }
  }

  const Json& root_;
  std::size_t max_faces_;
  ModelData data_;
  TexturedMesh mesh_;
  std::vector<TexturePlace> places_;  // per material
  std::map<int, int> textures_of_images_;
  bool has_colours_ = false;
};

}  // namespace

Result<TexturedMesh> ReadTexturedModel(std::string_view bytes,
                                       const ResourceLookup& beside,
                                       std::size_t max_faces) {
  GlbChunks chunks{bytes, {}};
  if (bytes.starts_with("glTF")) {
    Findings findings;
    const std::optional<GlbChunks> read = ReadGlbChunks(bytes, findings);
    if (!read) return InvalidInput("not a readable GLB: " + findings.errors.front());
    chunks = *read;
  }
  if (const std::string fault = NestingFault(chunks.json); !fault.empty())
    return InvalidInput("not a readable glTF: JSON is " + fault);
  try {
    const Json root = Json::parse(chunks.json.begin(), chunks.json.end(), nullptr, false);
    if (root.is_discarded() || !root.is_object())
      return InvalidInput("not a readable glTF: its JSON is damaged or cut off");
    return ModelReader(root, chunks.binary, beside, max_faces).Read();
  } catch (const std::exception& e) {
    return InvalidInput(std::string("not a readable glTF: ") + e.what());
  }
}

}  // namespace deepslam::gltf
