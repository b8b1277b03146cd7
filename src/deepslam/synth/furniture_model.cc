#include "deepslam/synth/furniture_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "deepslam/geometry/box.h"
#include "deepslam/image_codec/decode.h"

namespace deepslam::synth {
namespace {

// Texture detail on the mesh; about three pixels of a 640 px wide camera at 2 m.
constexpr float kTexturedEdgeM = 0.012f;
constexpr int kMaxDivisions = 7;  // of a face in four, at most 16384 faces

struct Corner {
  Eigen::Vector3f p = Eigen::Vector3f::Zero();
  Eigen::Vector2f uv = Eigen::Vector2f::Zero();
  Eigen::Vector3f colour = Eigen::Vector3f::Ones();
};

struct Material {
  Eigen::Vector3f colour = SurfaceMaterial().diffuse;
  const ColourImage* texture = nullptr;  // times the colour; null: none
  bool shiny = false;
};

// Empty where one cannot be decoded, which `warnings` say.
std::vector<ColourImage> DecodeTextures(const TexturedMesh& mesh,
                                        std::vector<std::string>& warnings) {
  std::vector<ColourImage> textures;
  for (const std::string& bytes : mesh.textures) {
    Result<ColourImage> texture = image_codec::DecodeColour(bytes);
    if (!texture) {
      warnings.push_back(fmt::format("texture {} of {} is left out: {}",
                                     textures.size() + 1,
                                     mesh.textures.size(),
                                     texture.error().message));
    }
    textures.push_back(texture ? *std::move(texture) : ColourImage());
  }
  return textures;
}

std::vector<Material> DecodeMaterials(const TexturedMesh& mesh,
                                      const std::vector<ColourImage>& textures) {
  std::vector<Material> materials;
  for (const SurfaceMaterial& from : mesh.materials) {
    Material material;
    const auto number = static_cast<std::size_t>(from.texture);
    if (from.texture >= 0 && number < textures.size() && !textures[number].empty())
      material.texture = &textures[number];
    const Eigen::Vector3f& colour = material.texture == nullptr ? from.diffuse : from.tint;
    if (colour.allFinite()) material.colour = colour.cwiseMax(0.0f).cwiseMin(1.0f);
    material.shiny = from.shiny;
    materials.push_back(std::move(material));
  }
  return materials;
}

Rgb8 ColourAt(const Material& material, const Corner& corner) {
  Eigen::Vector3f colour = material.colour.cwiseProduct(corner.colour);
  if (material.texture != nullptr && corner.uv.allFinite()) {
    const auto wrapped = [](float x) { return x - std::floor(x); };
    const ColourImage& t = *material.texture;
    const int u = std::clamp(
        static_cast<int>(wrapped(corner.uv.x()) * static_cast<float>(t.width())), 0, t.width() - 1);
    const int v =
        std::clamp(static_cast<int>((1 - wrapped(corner.uv.y())) * static_cast<float>(t.height())),
                   0,
                   t.height() - 1);
    const Rgb8 pixel = t(u, v);
    colour = colour.cwiseProduct(Eigen::Vector3f(pixel.r, pixel.g, pixel.b) / 255.0f);
  }
  const auto byte = [](float c) {
    return static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(c, 0.0f, 1.0f)));
  };
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
  if (material.texture != nullptr && longest > kTexturedEdgeM && divisions < kMaxDivisions &&
      mesh.faces.size() < kMaxModelFaces / 4) {
    std::array<Corner, 3> middle;
    for (std::size_t i = 0; i < 3; ++i) {
      const Corner& a = face[i];
      const Corner& b = face[(i + 1) % 3];
      middle[i] = {0.5f * (a.p + b.p), 0.5f * (a.uv + b.uv), 0.5f * (a.colour + b.colour)};
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
    mesh.colours.push_back(ColourAt(material, corner));
  }
  mesh.faces.push_back({first, first + 1, first + 2});
  model.shiny.push_back(material.shiny ? 1 : 0);
}

// The file's axes (x left, y up, z front) to the object's (x front, y left, z up), real size, box
// in the middle.
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

Result<ObjectFromFile> FitToSize(const TexturedMesh& mesh,
                                 const Eigen::Matrix3d& rotation,
                                 const std::optional<CatalogueSize>& given) {
  Box3 box;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (const std::uint32_t vertex : mesh.faces[f].vertices) {
      if (vertex >= mesh.vertices.size()) {
        return InvalidInput(fmt::format(
            "face {} names vertex {} of {}: the file is damaged", f, vertex, mesh.vertices.size()));
      }
      const Eigen::Vector3d p = rotation * mesh.vertices[vertex];
      if (!p.allFinite()) return InvalidInput(fmt::format("vertex {} is not finite", vertex));
      box.Extend(p);
    }
  }
  if (box.empty()) return InvalidInput("has no faces; export it as triangles");
  if (!(box.Size().minCoeff() > 0)) return InvalidInput("is flat: no furniture");
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

Error TooManyFaces(std::size_t num_faces) {
  return InvalidInput(
      fmt::format("has {} faces, more than {}; make it coarser (Blender: Decimate, MeshLab: "
                  "Quadric Edge Collapse)",
                  num_faces,
                  kMaxModelFaces));
}

Result<FurnitureModel> MakeFurnitureModel(const TexturedMesh& mesh,
                                          const Eigen::Matrix3d& rotation,
                                          const std::optional<CatalogueSize>& size) {
  if (mesh.faces.size() > kMaxModelFaces) return TooManyFaces(mesh.faces.size());
  const Result<ObjectFromFile> object_from_file = FitToSize(mesh, rotation, size);
  if (!object_from_file) return object_from_file.error();
  FurnitureModel model;
  const std::vector<ColourImage> textures = DecodeTextures(mesh, model.warnings);
  const std::vector<Material> materials = DecodeMaterials(mesh, textures);
  const Material grey;
  const bool has_colours = mesh.colours.size() == mesh.vertices.size();
  for (const TexturedMesh::Face& from : mesh.faces) {
    std::array<Corner, 3> face;
    for (std::size_t c = 0; c < 3; ++c) {
      face[c].p = *object_from_file * mesh.vertices[from.vertices[c]];
      face[c].uv = from.places[c];
      if (has_colours) face[c].colour = mesh.colours[from.vertices[c]];
    }
    const bool known =
        from.material >= 0 && static_cast<std::size_t>(from.material) < materials.size();
    AddFace(face, known ? materials[static_cast<std::size_t>(from.material)] : grey, 0, model);
  }
  const Eigen::Vector3d& size_m = object_from_file->size_m;
  model.size_m = {size_m.z(), size_m.x(), size_m.y()};
  return model;
}

}  // namespace deepslam::synth
