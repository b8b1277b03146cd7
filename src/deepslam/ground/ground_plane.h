// The ground plane: found among the horizontal planes of all keyframes, then propagated by the
// tracked poses, re-identified and robustly refined in every keyframe that sees it (paper: plane
// and object segmentation).
//
// The ground is the lowest large plane within the permissible orientations: a table top has floor
// points below it somewhere in the capture, the floor has nothing substantial below it. After long
// stretches without floor it is looked for as far as tracking may have drifted (reidentify.h).
//
// Parts that tracking did not measure against each other are searched each for themselves. Cameras
// held on their side or upside down are told by the ground itself (held_camera.h).
#pragma once

#include <string>

#include "deepslam/core/options.h"
#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::ground {

struct GroundOptions {
  double max_pitch_down_deg =
      70;  // permissible orientation of the camera against the ground: looking down ...
  double max_pitch_up_deg = 25;  // ... looking up ...
  double max_roll_deg = 30;      // ... tilted sideways
  // Clockwise turn that sets the pictures upright: auto | 0 | 90 | 180 | 270.
  std::string upright_deg = "auto";
  double min_height_m = 0.3;  // permissible height of the camera above the ground
  double max_height_m = 2.5;
  double max_depth_m = 5.0;          // farther points are left out
  double min_inlier_share = 0.02;    // of the frame's points on the plane, for an observation
  double min_area_m2 = 0.05;         // covered by the inliers of an observation
  double level_separation_m = 0.15;  // planes closer than this in height are one
  int num_ransac_draws = 300;
  double correlation_length_px =
      9;  // of depth errors, pixels of a 640 pixel wide image; scales the information
  double floor_angle_deg = 0.3;  // systematic errors of one observation, one standard deviation
  double floor_distance_m = 0.004;
};

void Describe(OptionsVisitor& visitor, GroundOptions& options);

// Stage `ground`. A capture in which no ground is seen gives a Ground with no plane, which is not
// an error. Warns where the ground is so near below the camera that it may be a table top. Errors:
// Interrupted.
[[nodiscard]] Result<Ground> EstimateGround(const FrameSource& frames,
                                            const Odometry& odometry,
                                            const GroundOptions& options,
                                            Progress& progress);

}  // namespace deepslam::ground
