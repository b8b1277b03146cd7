// Furniture meshes out of catalogues and files.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "deepslam/core/result.h"
#include "deepslam/library/catalogue.h"
#include "deepslam/library/zip_archive.h"
#include "deepslam/synth/furniture_model.h"

namespace deepslam::tools {

// Of one entry of a catalogue; larger ones are no furniture.
inline constexpr std::size_t kMaxEntryBytes = std::size_t{256} << 20;

[[nodiscard]] Result<synth::FurnitureModel> ReadCatalogueModel(const library::ZipArchive& archive,
                                                               const library::CatalogueItem& item);

// By its name: .obj, .glb or .gltf.
[[nodiscard]] bool IsFurnitureFile(const std::string& model);

// A model of the user's: x left, y up, z front, metres, as glTF has it. A size that is asked for is
// the model's own, so that files in any unit are divided as finely as their real size needs.
[[nodiscard]] Result<synth::FurnitureModel> ReadFurnitureFile(
    const std::filesystem::path& file, const std::optional<synth::CatalogueSize>& size);

}  // namespace deepslam::tools
