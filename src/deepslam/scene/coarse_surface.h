// The surface of a whole capture in voxels of a few centimetres, and the space that its frames
// looked through: what walls and things are read from.
//
// Everything but `level_from_tracking` is in the level world: z up, and the ground at z = 0 where
// one was seen. Distances in metres.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "deepslam/geometry/pose.h"
#include "deepslam/scene/observed_space.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam {

struct CoarseSurface {
  double voxel_m = 0;
  // Faces counter-clockwise as seen from the free side; vertices in lexicographic order. Coloured
  // where the frames came with colour.
  TriangleMesh mesh;
  std::vector<Eigen::Vector3f> normals;     // per vertex, unit, towards the free side
  std::vector<std::int32_t> num_frames;     // per vertex: how many of the fused frames saw it
  ObservedSpace space;                      // of the same voxels
  std::vector<Eigen::Vector3f> viewpoints;  // where the cameras of the fused frames were, in order
  Pose3 level_from_tracking;                // tracking world -> level world
  bool has_ground = false;                  // false: upright as the first camera was held, at most
};

}  // namespace deepslam
