// The back end: keyframe poses, object poses and the ground plane in one least-squares problem,
// solved by Levenberg-Marquardt (paper, "Graph optimization"), and everything turned into the
// gravity-aligned world afterwards.
//
// Variables: x_wi (keyframes), x_wo (objects), p = (n, d) (ground; minimal, 3 degrees of freedom: n
// on the unit sphere, d on the line). Terms of the energy, each r^T Omega r:
//   r_io  = t2v(z_io^-1 x_wi^-1 x_wo)                       per usable view of an object
//   r_ij  = t2v(z_ij^-1 x_wi^-1 x_wj)         x lambda_1    per odometry edge
//   r_pi  = p - [R n_i; d_i - (R n_i)^T t]    x lambda_2    per keyframe that saw the ground
//   r_po  = n - R (0, 0, 1)^T                 x lambda_3    per object that stands on the ground
//   loop  = r_ij of a verified loop edge      x lambda_1
//   r_pw  = r_pi of a wall's plane       x lambda_2, with the ground's loss, per keyframe that saw
//   it
// Past the paper: the last, and robust losses on r_io, r_pi and loop. How r_pi's information is
// carried to the world: residuals.h.
// t2v is (translation m; rotation vector rad), information in that order.
//
// Balance. Information from registrations (H = J^T J) counts each pixel as independent and the
// model as true; neither holds, so as it stands the edge with most pixels would rule. Every edge's
// covariance becomes
//   Sigma' = variance_scale * H^-1 + floor^2,
// where the scale stands for the correlation of neighbouring pixels and the floor for what does not
// average out within one edge: calibration and depth bias (odometry), the difference between model
// and object (objects), unevenness (ground). Directions without information (H's null space, a free
// yaw) stay without. So all terms are in units of their own standard deviation and lambda_1 =
// lambda_2 = 1 is the natural balance; lambda_3 is 1 / (tilt deviation)^2.
//
// Robust losses are applied in rounds of shrinking width (graduated non-convexity), so that a true
// loop whose first residual is the whole drift still closes, while a wrong registration ends with
// next to no weight.
//
// Gauge: the first keyframe is held. All terms depend on relative quantities only (the plane is a
// variable too), so exactly six degrees of freedom are free, and the first keyframe is the tracking
// world's own origin. Keyframes no edge reaches are tied to their predecessor by their tracked
// relative pose with low information. Scale is kept as is.
//
// Determinism: residuals are evaluated and summed on one thread (Ceres sums per-thread parts in an
// order that depends on scheduling), linear systems are solved by Eigen's sparse Cholesky
// (single-threaded, unlike BLAS-backed ones), those of large graphs by conjugate gradients that the
// Cholesky factor of some of the edges preconditions (subgraph_edges.h).
#pragma once

#include <map>
#include <string>

#include "deepslam/core/ids.h"
#include "deepslam/core/options.h"
#include "deepslam/core/result.h"
#include "deepslam/graph/wall_view.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/loop.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/scene/object_map.h"
#include "deepslam/scene/optimized_map.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::graph {

struct GraphOptions {
  // Lambda_1, dimensionless: 1, since every term is in units of its own deviation.
  static constexpr double kLambdaOdometry = 1.0;
  // Lambda_2, dimensionless, likewise.
  static constexpr double kLambdaGround = 1.0;
  static constexpr double kLambdaUpright =
      13000;  // lambda_3, rad^-2: (0.5 deg)^-2, how plumb furniture stands

  // Sigma' = scale * H^-1 + floor^2. 10: the noise of structured-light and time-of-flight depth is
  // correlated over windows of roughly 3 x 3 pixels and more.
  static constexpr double kOdometryVarianceScale = 10;
  // Least deviation of an odometry edge: calibration and depth bias.
  static constexpr double kOdometryFloor_m = 0.003;
  // And of its rotation.
  static constexpr double kOdometryFloor_deg = 0.1;
  // A retrieved model is near the object, not equal to it, and voxels are 1-3 cm wide.
  static constexpr double kObjectVarianceScale = 10;
  // Least deviation of an object registration: the model is not the object.
  static constexpr double kObjectFloor_m = 0.03;
  // And of its rotation.
  static constexpr double kObjectFloor_deg = 3.0;
  // As of odometry.
  static constexpr double kGroundVarianceScale = 10;
  // Least deviation of a ground observation: floors are uneven.
  static constexpr double kGroundFloor_m = 0.01;
  // And of its normal.
  static constexpr double kGroundFloor_deg = 0.5;
  // Least deviation of a wall observation, as of the ground; so is the scale.
  static constexpr double kWallFloor_m = 0.01;
  // And of its normal.
  static constexpr double kWallFloor_deg = 0.5;

  // Loss per kind: none | huber | cauchy. The paper has none. Width in standard deviations of the
  // whole residual (the mean of chi with 6 degrees of freedom is 2.4, its 0.999 quantile 4.7).
  std::string object_loss = "cauchy";
  std::string odometry_loss = "none";
  std::string loop_loss = "cauchy";
  std::string ground_loss = "cauchy";
  // Residual, in deviations, from which the losses bend: between the mean of chi with 6 degrees of
  // freedom (2.4) and its 0.999 quantile (4.7).
  static constexpr double kLossWidth = 3.0;
  int loss_rounds = 3;  // widths 16x, 4x, 1x for 3; 1 = no graduation

  bool use_objects = true;  // r_io and r_po; else objects follow their keyframes
  bool use_walls = false;   // r_pw: a wall is one plane in all keyframes that saw it
  // Objects whose bottom is seen farther than this from the ground hang, or stand on something.
  static constexpr double kStandMaxGap_m = 0.25;

  int max_iterations = 60;  // per round
  // Graphs of more keyframes are solved by conjugate gradients, in time and memory that grow with
  // the number of edges; up to here a factorisation is as fast.
  int max_direct_keyframes = 200;
  // Longer paths are solved by fewer nodes (condense.h), in memory that hardly grows with them.
  int max_keyframes = 1500;
  bool interpolate_frames =
      true;  // frames between keyframes: blend of both corrections; else rigid
};

void Describe(OptionsVisitor& visitor, GraphOptions& options);

// How an object meets what it rests on.
struct ObjectFoot {
  double bottom_m = 0;  // lowest z of its model in the metric object frame (negative)
  // What things of its class rest on. One that rests on furniture or hangs on a wall has no r_po.
  Supports supports = {};
};

// What is known beside the measurements along the path.
struct GraphSurroundings {
  std::map<ObjectId, ObjectFoot> feet;  // objects that are missing count as on the ground
  WallViews walls;                      // along the odometry's path
};

// Optimises, then turns everything into the gravity-aligned world (gravity_world.h). `map` is the
// map after merging.
//
// Objects without a usable view keep their pose relative to the keyframe of their best view. Frames
// between keyframes that are nodes (all, but of long paths: condense.h): where a frame was tracked
// against its preceding keyframe, its poses as carried by the keyframe before and the one after are
// blended by frame number, so that no jump appears at a keyframe; else it moves rigidly with the
// keyframe it was tracked against. An object that leans more than 5 deg afterwards, or does not
// stand, says so in its note; the largest tilt is in the summary's message. A solver that fails
// leaves the poses as they were: summary.converged = false and the reason. Errors (kInvalidInput):
// frames not numbered 0..n-1, keyframes not ascending or out of range, poses not finite. Bad edges
// (out of range, not finite, no information) are left out and counted in the message.
[[nodiscard]] Result<OptimizedMap> OptimizeGraph(const Odometry& odometry,
                                                 const Ground& ground,
                                                 const ObjectMap& map,
                                                 const Loops& loops,
                                                 const GraphOptions& options,
                                                 const GraphSurroundings& surroundings = {});

// The same graph as g2o text (g2o.h): VERTEX_SE3:QUAT, EDGE_SE3:QUAT, FIX, ground terms as
// comments. Vertices stand at the poses of `after` when given, else at the input's. Edges carry the
// balanced information, lambda included, without robust losses (g2o files have none) and walls.
// Keyframes that are nodes have their frame number as id, objects kObjectVertexOffset + id.
[[nodiscard]] Result<std::string> GraphToG2o(const Odometry& odometry,
                                             const Ground& ground,
                                             const ObjectMap& map,
                                             const Loops& loops,
                                             const GraphOptions& options,
                                             const GraphSurroundings& surroundings = {},
                                             const OptimizedMap* after = nullptr);

}  // namespace deepslam::graph
