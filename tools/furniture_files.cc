#include "furniture_files.h"

#include <algorithm>
#include <cctype>

#include "deepslam/dataset/image_files.h"
#include "deepslam/dataset/read_bytes.h"
#include "deepslam/gltf/textured_model.h"
#include "deepslam/synth/obj_model.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;

std::string Extension(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return extension;
}

}  // namespace

Result<synth::FurnitureModel> ReadCatalogueModel(const library::ZipArchive& archive,
                                                 const library::CatalogueItem& item) {
  const Result<std::string> obj = archive.Read(item.model, kMaxEntryBytes);
  if (!obj) return obj.error();
  const fs::path folder = fs::path(item.model).parent_path();
  const auto beside = [&](const std::string& name) -> std::optional<std::string> {
    Result<std::string> bytes = archive.Read((folder / name).generic_string(), kMaxEntryBytes);
    return bytes ? std::optional<std::string>(*std::move(bytes)) : std::nullopt;
  };
  return synth::ParseObjModel(
      *obj, beside, item.rotation, synth::CatalogueSize{item.width_m, item.depth_m, item.height_m});
}

bool IsFurnitureFile(const std::string& model) {
  const std::string extension = Extension(model);
  return extension == ".obj" || extension == ".glb" || extension == ".gltf";
}

Result<synth::FurnitureModel> ReadFurnitureFile(const fs::path& file,
                                                const std::optional<synth::CatalogueSize>& size) {
  const Result<std::string> bytes = dataset::ReadFileBytes(file, kMaxEntryBytes);
  if (!bytes) return bytes.error();
  const auto beside = [&](const std::string& name) -> std::optional<std::string> {
    Result<std::string> found = dataset::ReadFileBytes(file.parent_path() / name, kMaxEntryBytes);
    return found ? std::optional<std::string>(*std::move(found)) : std::nullopt;
  };
  const Result<TexturedMesh> mesh =
      Extension(file) == ".obj" ? synth::ReadObj(*bytes, beside)
                                : gltf::ReadTexturedModel(*bytes, beside, synth::kMaxModelFaces);
  if (!mesh) return InvalidInput(file.string() + ": " + mesh.error().message);
  Result<synth::FurnitureModel> model =
      synth::MakeFurnitureModel(*mesh, Eigen::Matrix3d::Identity(), size);
  if (!model) return InvalidInput(file.string() + ": " + model.error().message);
  return model;
}

}  // namespace deepslam::tools
