// The item list of a Sweet Home 3D furniture catalogue (PluginFurnitureCatalog.properties).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/result.h"

namespace deepslam::library {

struct CatalogueItem {
  std::string id;          // "Scopia#chair3"
  std::string name;        // UTF-8
  std::string creator;     // UTF-8
  std::string model;       // path of the OBJ inside the archive, without leading '/'
  double width_m = 0;      // along the model's x after `rotation`
  double depth_m = 0;      // along z, the front being +z
  double height_m = 0;     // along y
  double elevation_m = 0;  // above the floor
  bool door_or_window = false;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // of the file's coordinates, y up
  std::string fault;  // why the item cannot be used; empty = fine
};

struct Catalogue {
  std::string name;
  std::string licence;               // UTF-8, one line
  std::vector<CatalogueItem> items;  // ascending number in the file
};

// Parses the bytes of the properties file: Latin-1 with \uXXXX escapes, `key=value` lines, `key#N`
// per item. An item with a missing or bad field comes back with its `fault`. Error: no item at all.
[[nodiscard]] Result<Catalogue> ParseCatalogue(std::string_view latin1);

}  // namespace deepslam::library
