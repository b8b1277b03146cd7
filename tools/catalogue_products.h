// Products out of the catalogues on disk and meshes out of folders.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "training_products.h"

namespace deepslam::tools {

struct ProductRequest {
  std::vector<std::string> classes;
  bool catalogue = true;  // with its products
  std::filesystem::path catalogues;
  std::filesystem::path withheld_list;
  std::vector<std::filesystem::path> mesh_folders;  // with .../CLASS/name.obj (or .glb, .gltf)
};

// Catalogues first, then folders; withheld products are marked by their split. Meshes like a
// withheld product are dropped.
[[nodiscard]] Result<TrainingProducts> ListProducts(const ProductRequest& request,
                                                    Progress& progress);

}  // namespace deepslam::tools
