// Relaxation of a voxel boundary: the smoothest surface that stays with its voxels.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "deepslam/mesh/voxel_boundary.h"

namespace deepslam::mesh {

// New places of the boundary's vertices, in voxels: least sum of squared umbrella vectors (bending,
// not area, so that round shapes do not shrink), each vertex within `max_shift` of its corner per
// axis and less the farther the next step of its face is, so that faces without steps keep their
// place and their edges; parts and gaps of one or two voxels stay at least 0.8 and 1.1 voxels wide.
[[nodiscard]] std::vector<Eigen::Vector3d> RelaxBoundary(const VoxelBoundary& boundary,
                                                         int iterations,
                                                         double max_shift);

}  // namespace deepslam::mesh
