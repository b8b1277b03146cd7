// `deepslam synth`: a scene file becomes a capture folder with its truth.
#pragma once

#include <filesystem>

#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"

namespace deepslam::tools {

// Where Debian's sweethome3d-furniture puts the catalogues.
inline constexpr const char* kCatalogueFolder = "/usr/share/sweethome3d/furniture";

// Renders the scene with furniture of the *.sh3f catalogues into `out`, which must not exist or be
// empty: TUM layout, truth/objects.json, truth/meshes/<id>.ply and truth/instances/<frame>.png.
// Rendered aside and moved into place at the end, so that `out` is a whole capture or not there.
Status SynthesiseCapture(const std::filesystem::path& scene_file,
                         const std::filesystem::path& catalogues,
                         const std::filesystem::path& out,
                         Progress& progress);

}  // namespace deepslam::tools
