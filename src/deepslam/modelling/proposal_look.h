// What the shape networks make of the views of tracked objects, for people who look at it.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/frames/frame.h"
#include "deepslam/modelling/view_source.h"
#include "deepslam/propose/network_crop.h"
#include "deepslam/propose/proposer.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::modelling {

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
  // The library's model that was ranked first; nothing without retrieval.
  std::optional<VoxelGrid> retrieved;
  std::string note;  // why a network gave no shape
};

// At most `max_views` views of every object of a class with networks, by object, spread round it.
// `retrieved`: the library's first model for each object that has one.
[[nodiscard]] Result<std::vector<ProposalLook>> LookAtProposals(
    const TrackedObjects& objects,
    const propose::ShapePriors& priors,
    const std::map<ObjectId, VoxelGrid>& retrieved,
    const ViewSource& views,
    int max_views);

}  // namespace deepslam::modelling
