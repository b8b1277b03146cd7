// The ground plane: seen in keyframes, and once for the whole world.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/ids.h"
#include "deepslam/core/quarter_turn.h"
#include "deepslam/geometry/plane.h"
#include "deepslam/geometry/pose.h"

namespace deepslam {

struct GroundObservation {
  FrameIdx keyframe;
  Plane plane_camera;  // normal up, d = height of the camera above the ground
  // Information on (two rotations of n about axes of a tangent basis, d): see GroundTangentBasis.
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();
  int num_inliers = 0;  // pixels
};

// Frames [first, end) whose place relative to the first keyframe tracking did not measure
// (measured_parts.h): its ground says nothing about theirs.
struct GroundApart {
  FrameIdx first;
  FrameIdx end;
  std::optional<Plane> plane_world;  // theirs; nothing when they saw none
};

struct Ground {
  // In the tracking world, as the frames saw it that were registered to the first keyframe;
  // nothing when they saw none.
  std::optional<Plane> plane_world;
  std::vector<GroundObservation>
      observations;                // ascending keyframes; only those where ground was seen
  std::vector<GroundApart> apart;  // all others; ascending, disjoint
  // What the user says sets the pictures upright; counts where no ground is known.
  std::optional<QuarterTurn> upright;
};

// The sub-trajectory that holds the frame; null for frames that plane_world is of.
[[nodiscard]] const GroundApart* ApartAt(const Ground& ground, FrameIdx frame);

// The ground in a frame's camera: seen in this very frame, else carried from the world by the
// frame's pose.
[[nodiscard]] std::optional<Plane> GroundInCamera(const Ground& ground,
                                                  FrameIdx frame,
                                                  const Pose3& world_from_camera);

// Two unit vectors that with `normal` make a right-handed basis; columns. The tangent directions of
// a plane's normal: n' = (n + B * (a, b)^T) / |...|. A deterministic function of the normal.
[[nodiscard]] Eigen::Matrix<double, 3, 2> GroundTangentBasis(const Eigen::Vector3d& normal);

}  // namespace deepslam
