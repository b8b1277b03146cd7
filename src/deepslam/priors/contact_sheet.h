// Pictures for people who check training data.
#pragma once

#include <span>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/priors/training_view.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::priors {

struct SheetRow {
  std::vector<TrainingView> views;
  VoxelGrid shape;
};

// One row per model: crops; depth, height, and truth (depth, normals, silhouette) of the first;
// the shape seen from in front (from +x) and from its left (from +y: the front is then to the
// left), as shadows that are darker where more voxels lie behind one another.
[[nodiscard]] ColourImage DrawContactSheet(std::span<const SheetRow> rows);

}  // namespace deepslam::priors
