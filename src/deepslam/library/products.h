// Furniture of the catalogues as canonical models.
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

// A catalogue item of a mapped class.
struct Product {
  CatalogueItem item;
  std::string catalogue;  // file name, "Scopia.sh3f"
  std::string class_name;
  LibraryModel model;
  int quarter_turns = 0;  // CanonicalModel
  std::string dropped;    // why it cannot be used; empty = it can
};

struct Products {
  std::vector<Product> products;  // by catalogue's file name, then number in the catalogue
  int num_catalogue_items = 0;    // of all classes
  std::map<std::string, std::string> licences;  // texts by catalogue name
};

// All products of mapped classes, or of those in `classes` alone where it names some, and those of
// `wanted` ids whatever their class (without a mapped one: an empty class name). Errors name the
// folder or the catalogue that cannot be read.
[[nodiscard]] Result<Products> ReadProducts(const std::filesystem::path& catalogues,
                                            const std::vector<std::string>& wanted,
                                            Progress& progress,
                                            const std::vector<std::string>& classes = {});

}  // namespace deepslam::library
