#include "deepslam/synth/obj_model.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <tiny_obj_loader.h>

namespace deepslam::synth {
namespace {

std::string Slashed(std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  return name;
}

// By its path from the OBJ; many exporters write the path of their own machine, so else by its bare
// name.
std::optional<std::string> Find(const FileLookup& beside, const std::string& named) {
  const std::string name = Slashed(named);
  if (name.find('\0') != std::string::npos) return std::nullopt;
  const bool leads_away = name.starts_with('/') || name.find("..") != std::string::npos ||
                          name.find(':') != std::string::npos;
  if (!leads_away) {
    if (std::optional<std::string> bytes = beside(name)) return bytes;
  }
  const std::size_t slash = name.find_last_of('/');
  if (slash == std::string::npos) return std::nullopt;
  const std::string bare = name.substr(slash + 1);
  if (bare.empty() || bare == "." || bare == "..") return std::nullopt;
  return beside(bare);
}

std::string MaterialLibraries(const std::string& obj, const FileLookup& beside) {
  std::string text;
  std::istringstream lines(obj);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("mtllib")) continue;
    const std::size_t begin = line.find_first_not_of(" \t", 6);
    const std::size_t end = line.find_last_not_of(" \t\r");
    if (begin == std::string::npos || end < begin) continue;
    if (const std::optional<std::string> bytes = Find(beside, line.substr(begin, end - begin + 1)))
      text += *bytes + "\n";
  }
  return text;
}

// Lines that make at least one triangle each.
std::size_t CountFaceLines(std::string_view obj) {
  std::size_t count = 0;
  for (std::size_t at = 0; at < obj.size();) {
    const std::size_t begin = obj.find_first_not_of(" \t", at);
    if (begin != std::string_view::npos && begin + 1 < obj.size() && obj[begin] == 'f' &&
        (obj[begin + 1] == ' ' || obj[begin + 1] == '\t'))
      ++count;
    const std::size_t end = obj.find('\n', at);
    if (end == std::string_view::npos) break;
    at = end + 1;
  }
  return count;
}

// Exporters give nearly everything a highlight; a polished surface has a strong and narrow one and
// little colour of its own, glass lets light through.
bool IsShiny(const tinyobj::material_t& from) {
  constexpr float kClearOpacity = 0.6f;  // opacity `d` below which light goes through
  constexpr float kStrong = 0.8f;    // `Ks`, of 1
  constexpr float kNarrow = 100.0f;  // exponent `Ns`, up to 1000
  constexpr float kPale = 0.35f;     // `Kd`, of 1
  const float specular = std::min({from.specular[0], from.specular[1], from.specular[2]});
  const float diffuse = std::max({from.diffuse[0], from.diffuse[1], from.diffuse[2]});
  return from.dissolve < kClearOpacity ||
         (specular > kStrong && from.shininess > kNarrow && diffuse < kPale);
}

// Exporters write a black or grey diffuse beside a texture and mean the texture alone: the tint
// stays white.
void AddMaterials(const std::vector<tinyobj::material_t>& described,
                  const FileLookup& beside,
                  TexturedMesh& mesh) {
  std::map<std::string, int> textures;
  for (const tinyobj::material_t& from : described) {
    SurfaceMaterial material;
    material.diffuse =
        Eigen::Vector3d(from.diffuse[0], from.diffuse[1], from.diffuse[2]).cast<float>();
    material.shiny = IsShiny(from);
    if (const std::string& name = from.diffuse_texname; !name.empty()) {
      const auto [known, is_new] = textures.try_emplace(name, -1);
      if (is_new) {
        if (std::optional<std::string> bytes = Find(beside, name)) {
          known->second = static_cast<int>(mesh.textures.size());
          mesh.textures.push_back(*std::move(bytes));
        }
      }
      material.texture = known->second;
    }
    mesh.materials.push_back(material);
  }
}

TexturedMesh::Face FaceAt(const tinyobj::attrib_t& attributes,
                          const tinyobj::mesh_t& mesh,
                          std::size_t f) {
  TexturedMesh::Face face;
  for (std::size_t c = 0; c < 3; ++c) {
    const tinyobj::index_t& index = mesh.indices[3 * f + c];
    // Wrong ones become numbers that no mesh has.
    face.vertices[c] = static_cast<std::uint32_t>(index.vertex_index);
    const std::size_t t = 2 * static_cast<std::size_t>(std::max(index.texcoord_index, 0));
    if (index.texcoord_index >= 0 && t + 1 < attributes.texcoords.size()) {
      face.places[c] =
          Eigen::Vector2d(attributes.texcoords[t], attributes.texcoords[t + 1]).cast<float>();
    }
  }
  if (f < mesh.material_ids.size()) face.material = mesh.material_ids[f];
  return face;
}

}  // namespace

Result<TexturedMesh> ReadObj(const std::string& obj_bytes, const FileLookup& beside) {
  if (const std::size_t count = CountFaceLines(obj_bytes); count > kMaxModelFaces)
    return TooManyFaces(count);
  tinyobj::ObjReaderConfig config;
  config.triangulate = true;
  tinyobj::ObjReader reader;
  if (!reader.ParseFromString(obj_bytes, MaterialLibraries(obj_bytes, beside), config)) {
    return InvalidInput(fmt::format("not a readable OBJ: {}", reader.Error()));
  }
  const tinyobj::attrib_t& attributes = reader.GetAttrib();
  TexturedMesh mesh;
  for (std::size_t i = 0; i + 2 < attributes.vertices.size(); i += 3)
    mesh.vertices.emplace_back(
        attributes.vertices[i], attributes.vertices[i + 1], attributes.vertices[i + 2]);
  AddMaterials(reader.GetMaterials(), beside, mesh);
  for (const tinyobj::shape_t& shape : reader.GetShapes()) {
    for (std::size_t f = 0; 3 * f + 2 < shape.mesh.indices.size(); ++f)
      mesh.faces.push_back(FaceAt(attributes, shape.mesh, f));
  }
  return mesh;
}

Result<FurnitureModel> ParseObjModel(const std::string& obj_bytes,
                                     const FileLookup& beside,
                                     const Eigen::Matrix3d& rotation,
                                     const std::optional<CatalogueSize>& size) {
  const Result<TexturedMesh> mesh = ReadObj(obj_bytes, beside);
  if (!mesh) return mesh.error();
  return MakeFurnitureModel(*mesh, rotation, size);
}

}  // namespace deepslam::synth
