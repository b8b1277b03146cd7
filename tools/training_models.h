// The furniture that shape networks learn from and are tested on: designs made up by rules, the
// catalogues' products, and folders of meshes.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/result.h"
#include "deepslam/priors/training_view.h"
#include "deepslam/scene/voxel_grid.h"
#include "training_products.h"

namespace deepslam::tools {

struct TrainingModel {
  std::string id;  // "generated/chair/000012", "scopia/chair", "meshes/a/chair/b", with
                   // "~2" for the second variant, "~wide2" for a widened armchair, "~narrow2" for
                   // a narrowed sofa
  std::string class_name;  // of the map
  std::string kind;        // generated: "office_chair"; else the class
  std::string source;      // "generated", "catalogue" or "folder"
  std::string split;       // "train", "validate", or "withheld"; alike designs share one
  std::string credit;
  priors::FurnitureMesh furniture;
  VoxelGrid shape;
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  int symmetry = 1;  // turns about z that leave it as it is: 1, 2, 4; 0 = any
};

struct TrainingModelRequest {
  std::vector<std::string> classes;
  std::uint64_t seed = 1;
  int first_design = 0;
  int num_designs = 0;    // generated, of each class
  bool withheld = false;  // the withheld products instead of those for training, and nothing else
  int num_variants = 0;   // of each product and mesh: other proportions, other backs
  int num_widened = 0;    // sofas made of each armchair of the catalogues and folders
  int num_narrowed = 0;   // armchairs made of each of their sofas
};

// Classes whose products take part: those asked for, and those that are given another width.
[[nodiscard]] std::vector<std::string> ClassesToRead(const TrainingModelRequest& request);

// A model that is yet to be read or made.
struct TrainingModelSource;
class KnownShapes;

// The list of the models, which are made them one by one: meshes are large, so only some are held
// at once.
class TrainingModels {
 public:
  // Out of designs made up by rules and of `products`, which may be of more classes.
  [[nodiscard]] static TrainingModels Of(const TrainingModelRequest& request,
                                         TrainingProducts products);
  ~TrainingModels();
  TrainingModels(TrainingModels&&) noexcept;
  TrainingModels& operator=(TrainingModels&&) noexcept;

  [[nodiscard]] std::size_t size() const;
  // A product or mesh, not a design made up by rules.
  [[nodiscard]] bool IsProduct(std::size_t n) const;
  // Thread-safe. Variants are drawn anew where they are like a withheld product.
  [[nodiscard]] Result<TrainingModel> Make(std::size_t n) const;

 private:
  TrainingModels();
  std::vector<TrainingModelSource> sources_;
  std::unique_ptr<KnownShapes> withheld_;
  TrainingModelRequest request_;
};

}  // namespace deepslam::tools
