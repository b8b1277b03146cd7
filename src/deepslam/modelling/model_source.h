// Where the models of candidates come from.
#pragma once

#include <string>

#include "deepslam/core/result.h"
#include "deepslam/scene/shape_candidate.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::modelling {

class ModelSource {
 public:
  virtual ~ModelSource() = default;
  // The model of that key, which a candidate of this source has. The error names what is missing
  // or damaged. Thread-safe.
  [[nodiscard]] virtual Result<VoxelGrid> Read(CandidateSource source,
                                               const std::string& key) const = 0;
};

}  // namespace deepslam::modelling
