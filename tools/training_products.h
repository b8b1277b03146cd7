// Real furniture that training models are made of: products of catalogues and meshes of folders,
// read from where they are or from a pack.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/scene/triangle_mesh.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::tools {

struct TrainingProduct {
  std::string id;  // "scopia/chair", "meshes/a/chair/b"
  std::string class_name;
  std::string source;  // "catalogue" or "folder"
  std::string split;   // "train", "validate" or "withheld"; alike products share one
  std::string credit;
  bool between_arms = false;  // a seat between two arms, which may be given another width
  // In the canonical frame (z up, x front), metres. Thread-safe.
  std::function<Result<TriangleMesh>()> read;
};

struct TrainingProducts {
  std::vector<TrainingProduct> products;
  std::vector<VoxelGrid> withheld;   // of every class: no training model may be like one of these
  std::vector<std::string> dropped;  // "id: reason"
};

}  // namespace deepslam::tools
