// `deepslam synth`: a scene file becomes a capture folder with its truth.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"

namespace deepslam::tools {

// Where Debian's sweethome3d-furniture puts the catalogues.
inline constexpr const char* kCatalogueFolder = "/usr/share/sweethome3d/furniture";

struct SynthSummary {
  int num_frames = 0;
  std::vector<std::string> warnings;  // e.g. a way through a wall; each names the scene file
};

// Renders the scene (or its variant `rung`, empty: as it stands) into `out`, which must not exist
// or be empty: TUM layout, truth/objects.json, truth/meshes/<id>.ply, truth/room.ply and
// truth/instances/<frame>.png. Furniture: the *.sh3f catalogues in a folder, by id; OBJ files
// beside the scene or in that folder, by path. Rendered aside and moved into place at the end, so
// that `out` is a whole capture or not there.
Result<SynthSummary> SynthesiseCapture(const std::filesystem::path& scene_file,
                                       const std::string& rung,
                                       const std::filesystem::path& catalogues,
                                       const std::filesystem::path& out,
                                       Progress& progress);

}  // namespace deepslam::tools
