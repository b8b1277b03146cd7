#include "deepslam/synth/obj_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <sstream>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <tiny_obj_loader.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "deepslam/geometry/box.h"

namespace deepslam::synth {
namespace {

constexpr std::size_t kMaxFaces = 2'000'000;
// Texture detail on the mesh; about three pixels of a 640 px wide camera at 2 m.
constexpr float kTexturedEdgeM = 0.012f;
constexpr int kMaxDivisions = 7;
const Eigen::Vector3f kGrey(0.6f, 0.6f, 0.6f);

struct Corner {
  Eigen::Vector3f p = Eigen::Vector3f::Zero();
  Eigen::Vector2f uv = Eigen::Vector2f::Zero();
};

struct Material {
  Eigen::Vector3f diffuse = kGrey;  // display values, [0, 1]
  cv::Mat texture;                  // CV_8UC3, empty: none
  bool shiny = false;
};

std::string BaseName(std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  const std::size_t slash = name.find_last_of('/');
  return slash == std::string::npos ? name : name.substr(slash + 1);
}

std::string MaterialLibraries(const std::string& obj, const FileLookup& beside) {
  std::string text;
  std::istringstream lines(obj);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("mtllib")) continue;
    const std::size_t begin = line.find_first_not_of(" \t", 6);
    const std::size_t end = line.find_last_not_of(" \t\r");
    if (begin == std::string::npos || end < begin) continue;
    if (const std::optional<std::string> bytes =
            beside(BaseName(line.substr(begin, end - begin + 1)))) {
      text += *bytes + "\n";
    }
  }
  return text;
}

cv::Mat DecodeTexture(const std::string& bytes) {
  try {
    const cv::Mat raw(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data()));
    return bytes.empty() ? cv::Mat() : cv::imdecode(raw, cv::IMREAD_COLOR);
  } catch (const cv::Exception&) {
    return {};
  }
}

// Exporters give nearly everything a highlight; a polished surface has a strong and narrow one and
// little colour of its own, glass lets light through.
bool IsShiny(const tinyobj::material_t& from) {
  constexpr float kClear = 0.6f;
  constexpr float kStrong = 0.8f;
  constexpr float kNarrow = 100.0f;
  constexpr float kPale = 0.35f;
  const float specular = std::min({from.specular[0], from.specular[1], from.specular[2]});
  const float diffuse = std::max({from.diffuse[0], from.diffuse[1], from.diffuse[2]});
  return from.dissolve < kClear ||
         (specular > kStrong && from.shininess > kNarrow && diffuse < kPale);
}

std::vector<Material> ReadMaterials(const std::vector<tinyobj::material_t>& described,
                                    const FileLookup& beside) {
  std::map<std::string, cv::Mat> textures;
  std::vector<Material> materials;
  for (const tinyobj::material_t& from : described) {
    Material material;
    material.diffuse =
        Eigen::Vector3d(from.diffuse[0], from.diffuse[1], from.diffuse[2]).cast<float>();
    if (!material.diffuse.allFinite()) material.diffuse = kGrey;
    material.diffuse = material.diffuse.cwiseMax(0.0f).cwiseMin(1.0f);
    material.shiny = IsShiny(from);
    if (const std::string name = BaseName(from.diffuse_texname); !name.empty()) {
      if (!textures.contains(name)) {
        const std::optional<std::string> bytes = beside(name);
        textures[name] = bytes ? DecodeTexture(*bytes) : cv::Mat();
      }
      material.texture = textures[name];
      // Exporters write a black or grey diffuse beside a texture and mean the texture.
      if (!material.texture.empty()) material.diffuse = Eigen::Vector3f::Ones();
    }
    materials.push_back(material);
  }
  return materials;
}

Rgb8 ColourAt(const Material& material, const Eigen::Vector2f& uv) {
  Eigen::Vector3f colour = material.diffuse;
  if (!material.texture.empty() && uv.allFinite()) {
    const auto wrapped = [](float x) { return x - std::floor(x); };
    const cv::Mat& t = material.texture;
    const int u =
        std::clamp(static_cast<int>(wrapped(uv.x()) * static_cast<float>(t.cols)), 0, t.cols - 1);
    const int v = std::clamp(
        static_cast<int>((1 - wrapped(uv.y())) * static_cast<float>(t.rows)), 0, t.rows - 1);
    const cv::Vec3b bgr = t.at<cv::Vec3b>(v, u);
    colour = colour.cwiseProduct(Eigen::Vector3f(bgr[2], bgr[1], bgr[0]) / 255.0f);
  }
  const auto byte = [](float c) { return static_cast<std::uint8_t>(std::lround(255.0f * c)); };
  return {byte(colour.x()), byte(colour.y()), byte(colour.z())};
}

void AddFace(const std::array<Corner, 3>& face,
             const Material& material,
             int divisions,
             FurnitureModel& model) {
  TriangleMesh& mesh = model.mesh;
  const float longest = std::max({(face[0].p - face[1].p).norm(),
                                  (face[1].p - face[2].p).norm(),
                                  (face[2].p - face[0].p).norm()});
  if (!material.texture.empty() && longest > kTexturedEdgeM && divisions < kMaxDivisions &&
      mesh.faces.size() < kMaxFaces / 4) {
    std::array<Corner, 3> middle;
    for (std::size_t i = 0; i < 3; ++i) {
      const Corner& a = face[i];
      const Corner& b = face[(i + 1) % 3];
      middle[i] = {0.5f * (a.p + b.p), 0.5f * (a.uv + b.uv)};
    }
    AddFace({face[0], middle[0], middle[2]}, material, divisions + 1, model);
    AddFace({middle[0], face[1], middle[1]}, material, divisions + 1, model);
    AddFace({middle[2], middle[1], face[2]}, material, divisions + 1, model);
    AddFace(middle, material, divisions + 1, model);
    return;
  }
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const Corner& corner : face) {
    mesh.vertices.push_back(corner.p);
    mesh.colours.push_back(ColourAt(material, corner.uv));
  }
  mesh.faces.push_back({first, first + 1, first + 2});
  model.shiny.push_back(material.shiny ? 1 : 0);
}

// OBJ axes (x left, y up, z front) to the object's (x front, y left, z up), real size, box in the
// middle.
struct ObjectFromFile {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();  // turned, file units
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  // turned, file axes

  Eigen::Vector3f operator*(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d q = (turn * p - middle).cwiseProduct(scale);
    return Eigen::Vector3d(q.z(), q.x(), q.y()).cast<float>();
  }
};

Eigen::Vector3d VertexAt(const tinyobj::attrib_t& attributes, int index) {
  const auto i = static_cast<std::size_t>(3 * index);
  return Eigen::Vector3d(
      attributes.vertices[i], attributes.vertices[i + 1], attributes.vertices[i + 2]);
}

Result<ObjectFromFile> FitToSize(const tinyobj::attrib_t& attributes,
                                 const std::vector<tinyobj::shape_t>& shapes,
                                 const Eigen::Matrix3d& rotation,
                                 const std::optional<CatalogueSize>& given) {
  Box3 box;
  for (const tinyobj::shape_t& shape : shapes) {
    for (const tinyobj::index_t& index : shape.mesh.indices) {
      const bool there =
          index.vertex_index >= 0 &&
          3 * static_cast<std::size_t>(index.vertex_index) + 2 < attributes.vertices.size();
      if (!there) return InvalidInput("OBJ names a vertex that is not there");
      const Eigen::Vector3d p = rotation * VertexAt(attributes, index.vertex_index);
      if (!p.allFinite()) return InvalidInput("OBJ has a vertex that is not finite");
      box.Extend(p);
    }
  }
  if (box.empty()) return InvalidInput("OBJ has no faces");
  if (!(box.Size().minCoeff() > 0)) return InvalidInput("OBJ is flat");
  const CatalogueSize size =
      given.value_or(CatalogueSize{box.Size().x(), box.Size().z(), box.Size().y()});
  const Eigen::Vector3d wanted(size.width_m, size.height_m, size.depth_m);
  if (!wanted.allFinite() || !(wanted.minCoeff() > 0)) {
    return InvalidInput(fmt::format(
        "catalogue size {} x {} x {} m is not a size", size.width_m, size.depth_m, size.height_m));
  }
  return ObjectFromFile{rotation, wanted.cwiseQuotient(box.Size()), box.Center(), wanted};
}

}  // namespace

Result<FurnitureModel> ParseObjModel(const std::string& obj_bytes,
                                     const FileLookup& beside,
                                     const Eigen::Matrix3d& rotation,
                                     const std::optional<CatalogueSize>& size) {
  tinyobj::ObjReaderConfig config;
  config.triangulate = true;
  tinyobj::ObjReader reader;
  if (!reader.ParseFromString(obj_bytes, MaterialLibraries(obj_bytes, beside), config)) {
    return InvalidInput(fmt::format("not a readable OBJ: {}", reader.Error()));
  }
  const tinyobj::attrib_t& attributes = reader.GetAttrib();
  const Result<ObjectFromFile> object_from_file =
      FitToSize(attributes, reader.GetShapes(), rotation, size);
  if (!object_from_file) return object_from_file.error();
  const std::vector<Material> materials = ReadMaterials(reader.GetMaterials(), beside);

  FurnitureModel model;
  for (const tinyobj::shape_t& shape : reader.GetShapes()) {
    for (std::size_t f = 0; 3 * f + 2 < shape.mesh.indices.size(); ++f) {
      if (model.mesh.faces.size() > kMaxFaces)
        return InvalidInput(fmt::format("OBJ has more than {} faces", kMaxFaces));
      std::array<Corner, 3> face;
      for (std::size_t c = 0; c < 3; ++c) {
        const tinyobj::index_t& index = shape.mesh.indices[3 * f + c];
        face[c].p = *object_from_file * VertexAt(attributes, index.vertex_index);
        const auto t = static_cast<std::size_t>(2 * std::max(index.texcoord_index, 0));
        if (index.texcoord_index >= 0 && t + 1 < attributes.texcoords.size()) {
          face[c].uv =
              Eigen::Vector2d(attributes.texcoords[t], attributes.texcoords[t + 1]).cast<float>();
        }
      }
      const int id = f < shape.mesh.material_ids.size() ? shape.mesh.material_ids[f] : -1;
      const bool known = id >= 0 && static_cast<std::size_t>(id) < materials.size();
      AddFace(face, known ? materials[static_cast<std::size_t>(id)] : Material(), 0, model);
    }
  }
  const Eigen::Vector3d& size_m = object_from_file->size_m;
  model.size_m = {size_m.z(), size_m.x(), size_m.y()};
  return model;
}

}  // namespace deepslam::synth
