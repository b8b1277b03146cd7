// `deepslam synth`: a scene file becomes a capture folder with its truth.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"

namespace deepslam::tools {

struct SynthSummary {
  int num_frames = 0;
  std::vector<std::string> warnings;  // e.g. a way through a wall; each names the scene file
};

struct SynthRequest {
  std::filesystem::path scene_file;
  std::optional<std::uint64_t> home;   // in place of a scene file: a home made up by this seed
  std::string rung;                    // variant of the scene; empty: as it stands
  std::optional<double> frames_per_s;  // of the same way; nothing: as the scene says
  std::vector<std::string> settings;   // NAME=VALUE of how it is filmed (synth::FilmedWith)
  std::filesystem::path catalogues;    // folder with *.sh3f: furniture by id
  std::vector<std::filesystem::path> furniture;  // folders with OBJ, glTF and GLB files, by path
  std::filesystem::path out;                     // must not exist, or be empty
};

// Renders the scene into `out`: TUM layout, truth/objects.json, truth/layout.json,
// truth/meshes/<id>.ply, truth/room.ply and truth/instances/<frame>.png. Furniture in files is
// looked for beside the scene first, then in the furniture folders, then in that of the catalogues.
// Rendered aside and moved into place at the end, so that `out` is a whole capture or not there.
Result<SynthSummary> SynthesiseCapture(const SynthRequest& request, Progress& progress);

}  // namespace deepslam::tools
