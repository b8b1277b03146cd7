// The library of furniture models on disk: made once from Sweet Home 3D catalogues, read by every
// run.
//
// Layout of a library folder (format `deepslam-furniture/1`):
//   library.json     format, checksum, models: id, name, class, size_m, creator, licence, checksum,
//   file models/*.binvox  64^3 canonical models LICENSES.txt     one credit line per model, licence
//   texts of the catalogues
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/scene/model_library.h"

namespace deepslam::library {

// Reads and verifies a library folder. Errors name the file and what to do: folder missing or not a
// library, written by a newer program, a model file missing or with another checksum.
[[nodiscard]] Result<ModelLibrary> LoadLibrary(const std::filesystem::path& folder);

struct BuildLibraryOptions {
  std::filesystem::path catalogues;  // folder with *.sh3f catalogues
  std::filesystem::path
      out;  // library folder; replaced as a whole if it is a library or empty or missing
  std::vector<std::string>
      withheld;  // catalogue ids ("Scopia#chair") that must not enter, nor any shape like theirs
};

struct LibrarySummary {
  int num_catalogue_items = 0;           // items of all catalogues
  std::map<std::string, int> per_class;  // models written
  std::vector<std::string> dropped;  // "id: reason" of items of a mapped class that did not enter
  std::string checksum;              // of the library
};

// Deterministic: equal catalogues and options give equal bytes.
[[nodiscard]] Result<LibrarySummary> BuildLibrary(const BuildLibraryOptions& options,
                                                  Progress& progress);

// The `withheld` list of a YAML file such as configs/withheld_models.yaml (a list of catalogue ids
// under `withheld`).
[[nodiscard]] Result<std::vector<std::string>> ReadWithheldModels(
    const std::filesystem::path& file);

// Whether two canonical models show the same product: after b is stretched to a's box, in any of
// the four quarter turns, their intersection over union is above 0.9, or nearly all of each lies
// within a voxel of the other.
[[nodiscard]] bool ShapesAlike(const VoxelGrid& a, const VoxelGrid& b);

}  // namespace deepslam::library
