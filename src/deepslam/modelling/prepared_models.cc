#include "deepslam/modelling/prepared_models.h"

#include <utility>

namespace deepslam::modelling {
namespace {

std::size_t NumBytes(const shape::ShapeModel& model) {
  return model.grid().occupied.size() * (sizeof(std::uint8_t) + sizeof(float)) +
         model.surface_points().size() * 2 * sizeof(Eigen::Vector3f);
}

}  // namespace

PreparedModel PreparedModels::Find(const std::string& name) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = models_.find(name);
  return found == models_.end() ? nullptr : found->second;
}

void PreparedModels::Keep(const std::string& name, const PreparedModel& model) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (num_bytes_ > max_bytes_ || models_.contains(name)) return;
  num_bytes_ += NumBytes(*model);
  models_.emplace(name, model);
  if (num_bytes_ > max_bytes_) models_.clear();
}

PreparedModel PreparedModels::Prepare(const std::string& name, const VoxelGrid& grid) {
  PreparedModel known = Find(name);
  if (known && known->grid().occupied == grid.occupied) return known;
  const auto made = std::make_shared<const shape::ShapeModel>(grid);
  Keep(name, made);
  return made;
}

}  // namespace deepslam::modelling
