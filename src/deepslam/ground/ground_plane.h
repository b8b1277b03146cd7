// The ground plane: found among the horizontal planes of all keyframes, then propagated by the
// tracked poses, re-identified and robustly refined in every keyframe that sees it (paper: plane
// and object segmentation).
//
// The ground is the lowest large plane within the permissible orientations: a table top has floor
// points below it somewhere in the capture, the floor has nothing substantial below it. Where no
// keyframe shows enough of it, small patches of all of them tell (floor_patches.h). After long
// parts without floor it is looked for as far as tracking may have drifted (reidentify.h).
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
  // Permissible orientation of a camera that a hand holds against the ground: looking down by this
  // much, nobody films the own feet for long.
  static constexpr double kMaxPitchDown_deg = 70;
  // Looking up by this much: beyond it no floor is in a view of 50 degrees.
  static constexpr double kMaxPitchUp_deg = 25;
  // And tilted sideways by this much; pictures on their side are another matter (held_camera.h).
  static constexpr double kMaxRoll_deg = 30;
  // Clockwise turn that sets the pictures upright: auto | 0 | 90 | 180 | 270.
  std::string upright_deg = "auto";
  double min_height_m = 0.3;  // permissible height of the camera above the ground
  double max_height_m = 2.5;
  double max_depth_m = 5.0;  // farther points are left out
  // Share of the frame's points that an observation needs on the plane.
  static constexpr double kMinInlierShare = 0.02;
  // Ground that the inliers of an observation cover: a square of 22 cm.
  static constexpr double kMinArea_m2 = 0.05;
  // Planes closer than this in height are one level: drift of tracking in a room stays below, a
  // step or a low table above.
  static constexpr double kLevelSeparation_m = 0.15;
  // Draws per plane of a point, whose normal gives the plane: nine of them lie on one of the
  // smallest planes looked for, 3 % of the points, and the best of nine normals is little off.
  static constexpr int kNumRansacDraws = 300;
  // Length over which depth errors are shared, pixels of a 640 pixel wide image, as in tracking
  // (alignment_options.h); it scales the information.
  static constexpr double kCorrelationLength_px = 9;
  // Systematic error of one observation, one standard deviation: what a sensor's distortion tilts
  // a plane by.
  static constexpr double kFloorAngle_deg = 0.3;
  // The same of its distance: calibration of depth at 1.5 m.
  static constexpr double kFloorDistance_m = 0.004;
};

// A camera in a hand is higher above the floor: lower ones are on a robot, or above a table top.
inline constexpr double kLowCameraM = 0.9;

void Describe(OptionsVisitor& visitor, GroundOptions& options);

// Stage `ground`. A capture in which no ground is seen gives a Ground with no plane, which is not
// an error. Warns where the ground is so near below the camera that it may be a table top, and
// where small patches tell it. Errors: Interrupted.
[[nodiscard]] Result<Ground> EstimateGround(const FrameSource& frames,
                                            const Odometry& odometry,
                                            const GroundOptions& options,
                                            Progress& progress);

}  // namespace deepslam::ground
