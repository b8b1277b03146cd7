// Models prepared for matching that several stages of a run look at: registering, selecting and the
// report take the same ones, and objects share candidates.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "deepslam/scene/voxel_grid.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::modelling {

using PreparedModel = std::shared_ptr<const shape::ShapeModel>;

// Thread-safe. All models stay while they fit into the memory given. Where they do not, none does:
// the map is a large one, whose stages need the memory themselves. In no memory at all none stays,
// and each is prepared for who asks, which costs about a millisecond.
class PreparedModels {
 public:
  explicit PreparedModels(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  // The model of that grid. Another one of the same name counts for nothing.
  [[nodiscard]] PreparedModel Prepare(const std::string& name, const VoxelGrid& grid);

 private:
  [[nodiscard]] PreparedModel Find(const std::string& name) const;
  void Keep(const std::string& name, const PreparedModel& model);

  mutable std::mutex mutex_;
  const std::size_t max_bytes_;
  std::size_t num_bytes_ = 0;
  std::map<std::string, PreparedModel> models_;
};

}  // namespace deepslam::modelling
