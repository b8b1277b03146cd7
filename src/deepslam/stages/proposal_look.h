// What the shape networks make of the views of a finished association, for people who judge them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/propose/network_crop.h"
#include "deepslam/scene/frame.h"
#include "deepslam/scene/voxel_grid.h"
#include "deepslam/stages/plan.h"

namespace deepslam::stages {

// A whole shape, and from where the network believes that the camera sees it.
struct LookedShape {
  VoxelGrid shape;
  double azimuth_rad = 0;  // 0 = in front (+x), counter-clockwise from above
  double elevation_rad = 0;
};

struct ProposalLook {
  std::string object;  // "chair_03"
  FrameIdx frame;
  propose::NetworkCrop crop;  // with depth
  std::optional<LookedShape> by_depth;
  std::optional<LookedShape> by_colour;
  // The library's model that `propose` ranked first; nothing without retrieval.
  std::optional<VoxelGrid> retrieved;
  std::string note;  // why a network gave no shape
};

// At most `max_views` views of every object of a class with networks, by object, spread round it.
// InvalidInput when the workspace lacks stage `propose` or was made of another capture, or there
// are no networks.
[[nodiscard]] Result<std::vector<ProposalLook>> LookAtProposals(
    const std::filesystem::path& workspace,
    const RunInputs& inputs,
    int max_views,
    Progress& progress);

}  // namespace deepslam::stages
