// The graph as plain values: what is a variable, what is measured, with information balanced and
// bad input left out. The solver and the g2o writer both read this.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "deepslam/graph/object_graph.h"

namespace deepslam::graph {

enum class EdgeKind { kObject, kOdometry, kLoop };

struct PoseEdge {
  EdgeKind kind = EdgeKind::kOdometry;
  int a = 0;  // node
  int b = 0;  // node
  Pose3 a_from_b;
  Matrix6d information = Matrix6d::Zero();  // balanced, without lambda
  double weight = 1;                        // measurements that it stands for
};

struct GroundEdge {
  int node = 0;
  Plane plane_camera;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  // balanced, without lambda
};

struct WallEdge {
  int wall = 0;  // position in GraphModel::walls
  GroundEdge view;
};

struct GraphModel {
  std::vector<Pose3> world_from_node;  // keyframes in order, then the objects with usable views
  std::vector<FrameIdx> keyframes;     // that are nodes: all, or those that stand for the others
  std::vector<int> node_of_keyframe;   // of all of the path; ascending
  // Per node of a keyframe: behind this frame poses blend into the next node's. The keyframe, or
  // where the next one was not tracked from there, the last one that moves with it.
  std::vector<FrameIdx> blend_from;
  std::vector<std::size_t> objects;  // index into ObjectMap::objects of node keyframes.size() + k
  std::vector<PoseEdge> pose_edges;
  std::optional<Plane> plane;            // tracking world
  std::vector<GroundEdge> ground_edges;  // ascending nodes; none: the plane is held
  std::vector<Plane> walls;              // tracking world
  std::vector<WallEdge> wall_edges;      // each wall has two at least
  std::vector<int> upright;              // nodes
  std::vector<ObjectId> not_standing;    // bottom known, but too far from the ground
  int num_bad_edges = 0;                 // left out
  int num_ties = 0;                      // added where no edge reached a keyframe

  [[nodiscard]] int num_keyframes() const { return static_cast<int>(keyframes.size()); }
};

[[nodiscard]] Result<GraphModel> BuildGraphModel(const Odometry& odometry,
                                                 const Ground& ground,
                                                 const ObjectMap& map,
                                                 const Loops& loops,
                                                 const GraphOptions& options,
                                                 const GraphSurroundings& surroundings);

// In an ascending list; -1 for none of it.
[[nodiscard]] int PositionOf(const std::vector<FrameIdx>& keyframes, FrameIdx keyframe);

// The keyframe that `frame` is or was tracked against, as its position among all of the path; where
// that is none, the last keyframe not after it, else the first. -1 without keyframes or for a frame
// that does not exist.
[[nodiscard]] int KeyframeOfFrame(const Trajectory& trajectory, FrameIdx frame);

// The node that it moves with; -1 for none.
[[nodiscard]] int NodeOfFrame(const GraphModel& model,
                              const Trajectory& trajectory,
                              FrameIdx frame);

// Moves `model` to the optimum; the terms' energies before and after, robust losses left out of
// them.
[[nodiscard]] OptimizationSummary SolveGraph(GraphModel& model, const GraphOptions& options);

}  // namespace deepslam::graph
