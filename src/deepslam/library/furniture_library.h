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
#include "deepslam/library/catalogue.h"
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

struct WithheldProduct {
  std::string id;  // "Scopia#chair"
  std::string name;
  std::string class_name;
  std::string catalogue;  // file name
  std::string mesh;       // OBJ inside the catalogue
};

// Divides the catalogues' products of mapped classes into those that the library and training may
// hold and those that neither does: about `share` of each class is withheld. Products of one shape
// (and of shapes that a chain of alike ones joins) stay together, whatever their catalogue, size
// and class. The order in which they are taken is that of the hashes of their names, so it is the
// same for everybody. Ascending class, then id.
[[nodiscard]] Result<std::vector<WithheldProduct>> ChooseWithheld(
    const std::filesystem::path& catalogues, double share, Progress& progress);

// The list as text for ReadWithheldModels.
[[nodiscard]] std::string WithheldYaml(const std::vector<WithheldProduct>& withheld);

// The `withheld` list of a YAML file such as configs/withheld_models.yaml (a list of catalogue ids
// under `withheld`).
[[nodiscard]] Result<std::vector<std::string>> ReadWithheldModels(
    const std::filesystem::path& file);

// A catalogue's product with what is needed to render it.
struct CatalogueDesign {
  LibraryModel model;     // without checksum
  CatalogueItem item;     // mesh, rotation and size
  std::string catalogue;  // file name
  int quarter_turns = 0;  // counter-clockwise about z: of the mesh as the catalogue has it, so that
                          // its front is +x
  bool withheld = false;  // neither library nor training may hold it
};

// The products of `classes` that BuildLibrary would take, and the withheld ones of every class,
// marked; by catalogue's file name, then number in the catalogue. Errors as BuildLibrary.
[[nodiscard]] Result<std::vector<CatalogueDesign>> ReadDesigns(
    const std::filesystem::path& catalogues,
    const std::vector<std::string>& withheld,
    const std::vector<std::string>& classes,
    Progress& progress);

// Whether two canonical models show the same product (Alike, alike.h).
[[nodiscard]] bool ShapesAlike(const VoxelGrid& a, const VoxelGrid& b);

}  // namespace deepslam::library
