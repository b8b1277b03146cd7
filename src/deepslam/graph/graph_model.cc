#include "deepslam/graph/graph_model.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <utility>

#include "deepslam/core/angles.h"
#include "deepslam/core/disjoint_sets.h"
#include "deepslam/core/order_statistics.h"
#include "deepslam/graph/condense.h"
#include "deepslam/graph/information.h"

namespace deepslam::graph {
namespace {

// What a tie between keyframes without any measurement is worth: about a second of lost tracking.
constexpr double kTieDeviation_m = 0.1;
constexpr double kTieDeviation_rad = 5.0 * kRadPerDeg;  // the same for the turn

bool IsFinite(const Pose3& pose) {
  return pose.translation_m.allFinite() && pose.rotation.coeffs().allFinite() &&
         std::abs(pose.rotation.norm() - 1.0) < 1e-3;
}

std::optional<Plane> UnitPlane(const Plane& plane) {
  const double length = plane.normal.norm();
  if (!std::isfinite(length) || !std::isfinite(plane.d_m) || std::abs(length - 1.0) > 1e-3) {
    return std::nullopt;
  }
  return Plane{plane.normal / length, plane.d_m / length};
}

Vector6d Floor(double floor_m, double floor_deg) {
  Vector6d floor;
  floor << Eigen::Vector3d::Constant(floor_m), Eigen::Vector3d::Constant(floor_deg * kRadPerDeg);
  return floor;
}

Status CheckOdometry(const Odometry& odometry) {
  for (std::size_t k = 0; k < odometry.frames.size(); ++k) {
    const TrackedFrame& frame = odometry.frames[k];
    const std::string name = "trajectory: entry " + std::to_string(k);
    if (frame.frame.value != static_cast<int>(k)) {
      return InvalidInput(name + " is frame " + std::to_string(frame.frame.value) +
                          "; every frame of the capture must stand at its number");
    }
    if (!IsFinite(frame.world_from_camera)) return InvalidInput(name + " has no finite pose");
  }
  const int num_frames = static_cast<int>(odometry.frames.size());
  int previous = -1;
  for (const FrameIdx keyframe : odometry.keyframes) {
    if (keyframe.value <= previous || keyframe.value >= num_frames) {
      return InvalidInput("trajectory: keyframe " + std::to_string(keyframe.value) + " after " +
                          std::to_string(previous) + ": keyframes must ascend and be below the " +
                          std::to_string(num_frames) + " frames");
    }
    previous = keyframe.value;
  }
  return Ok();
}

// Between nodes that exist, finite, and measured at all.
bool IsUsable(const PoseEdge& edge) {
  return edge.a >= 0 && edge.b >= 0 && edge.a != edge.b && IsFinite(edge.a_from_b) &&
         edge.information.diagonal().maxCoeff() > 0;
}

// What was measured along the path as the graph has it: by tracking, then by loops. What loops
// re-registered stands for what tracking measured between the same two keyframes.
class PathEdges {
 public:
  PathEdges(const Odometry& odometry, const Loops& loops, const GraphOptions& options)
      : odometry_(odometry), loops_(loops), options_(options) {
    for (const RelativePose& edge : loops.edges) measured_again_.insert({edge.i, edge.j});
  }

  // Those that are usable; how many are not.
  int ForEach(const std::function<void(const PoseEdge&)>& use) const {
    int num_bad = 0;
    const auto take = [&](const RelativePose& measured, EdgeKind kind) {
      PoseEdge edge = ToPoseEdge(measured, kind);
      if (!IsUsable(edge)) {
        ++num_bad;
        return;
      }
      edge.a_from_b.rotation.normalize();
      use(edge);
    };
    odometry_.ForEachEdge([&](const RelativePose& edge) {
      if (!measured_again_.contains({edge.i, edge.j})) take(edge, EdgeKind::kOdometry);
    });
    for (const RelativePose& edge : loops_.edges) take(edge, EdgeKind::kLoop);
    return num_bad;
  }

 private:
  [[nodiscard]] PoseEdge ToPoseEdge(const RelativePose& measured, EdgeKind kind) const {
    const Vector6d floor = Floor(GraphOptions::kOdometryFloor_m, GraphOptions::kOdometryFloor_deg);
    // Loop edges come with an honest covariance of their own; their number of points says nothing.
    const double scale = kind == EdgeKind::kLoop ? 1.0 : GraphOptions::kOdometryVarianceScale;
    return {kind,
            PositionOf(odometry_.keyframes, measured.i),
            PositionOf(odometry_.keyframes, measured.j),
            measured.i_from_j,
            BalancedInformation<6>(measured.information.Full(), scale, floor)};
  }

  const Odometry& odometry_;
  const Loops& loops_;
  const GraphOptions& options_;
  std::set<std::pair<FrameIdx, FrameIdx>> measured_again_;
};

class ModelBuilder {
 public:
  explicit ModelBuilder(const Odometry& odometry) : odometry_(odometry) {
    model_.keyframes = odometry.keyframes;
    model_.blend_from = odometry.keyframes;
    for (const FrameIdx keyframe : odometry.keyframes) {
      model_.node_of_keyframe.push_back(static_cast<int>(model_.world_from_node.size()));
      model_.world_from_node.push_back(odometry.at(keyframe).world_from_camera);
    }
  }

  // Each keyframe must hang on the first one, else the problem is singular.
  void TieLooseKeyframes(const PathEdges& path) {
    DisjointSets joined(model_.keyframes.size());
    model_.num_bad_edges += path.ForEach([&](const PoseEdge& edge) {
      joined.Join(static_cast<std::uint32_t>(edge.a), static_cast<std::uint32_t>(edge.b));
    });
    Vector6d deviation;
    deviation << Eigen::Vector3d::Constant(kTieDeviation_m),
        Eigen::Vector3d::Constant(kTieDeviation_rad);
    const Matrix6d information = deviation.cwiseAbs2().cwiseInverse().asDiagonal();
    for (int node = 1; node < model_.num_keyframes(); ++node) {
      const auto here = static_cast<std::uint32_t>(node);
      if (!joined.Join(here - 1, here)) continue;
      const Pose3 a_from_b = Node(node - 1).Inverse() * Node(node);
      model_.pose_edges.push_back({EdgeKind::kOdometry, node - 1, node, a_from_b, information});
      ++model_.num_ties;
    }
  }

  void AddObjects(const ObjectMap& map) {
    for (std::size_t k = 0; k < map.objects.size(); ++k) {
      const std::vector<PoseEdge> edges = ObjectEdges(map.objects[k]);
      if (edges.empty()) continue;
      const int node = static_cast<int>(model_.world_from_node.size());
      model_.objects.push_back(k);
      edges_of_object_.push_back(edges);
      model_.world_from_node.push_back(StartPose(map.objects[k], edges));
      for (PoseEdge edge : edges) {
        edge.b = node;
        model_.pose_edges.push_back(edge);
      }
    }
  }

  void AddGround(const Ground& ground) {
    if (ground.plane_world) model_.plane = UnitPlane(*ground.plane_world);
    Eigen::Vector3d floor;
    floor << Eigen::Vector2d::Constant(GraphOptions::kGroundFloor_deg * kRadPerDeg),
        GraphOptions::kGroundFloor_m;
    for (const GroundObservation& observation : ground.observations) {
      const std::optional<Plane> plane = UnitPlane(observation.plane_camera);
      const int node = PositionOf(model_.keyframes, observation.keyframe);
      const Eigen::Matrix3d information = BalancedInformation<3>(
          observation.information, GraphOptions::kGroundVarianceScale, floor);
      if (!plane || node < 0 || information.diagonal().maxCoeff() <= 0) {
        ++model_.num_bad_edges;
        continue;
      }
      if (!model_.plane) model_.plane = Transformed(Node(node), *plane);
      model_.ground_edges.push_back({node, *plane, information});
    }
    std::stable_sort(model_.ground_edges.begin(),
                     model_.ground_edges.end(),
                     [](const GroundEdge& a, const GroundEdge& b) { return a.node < b.node; });
  }

  // Walls that one keyframe alone saw say nothing.
  void AddWalls(const WallViews& walls) {
    Eigen::Vector3d floor;
    floor << Eigen::Vector2d::Constant(GraphOptions::kWallFloor_deg * kRadPerDeg),
        GraphOptions::kWallFloor_m;
    std::vector<std::vector<GroundEdge>> edges(walls.planes.size());
    for (const WallView& view : walls.views) {
      const std::optional<Plane> plane = UnitPlane(view.plane_camera);
      const int node = PositionOf(model_.keyframes, view.keyframe);
      const bool is_known = view.wall >= 0 && view.wall < static_cast<int>(edges.size());
      const Eigen::Matrix3d information =
          BalancedInformation<3>(view.information, GraphOptions::kGroundVarianceScale, floor);
      if (!plane || node < 0 || !is_known || information.diagonal().maxCoeff() <= 0) {
        ++model_.num_bad_edges;
        continue;
      }
      edges[static_cast<std::size_t>(view.wall)].push_back({node, *plane, information});
    }
    for (std::size_t wall = 0; wall < edges.size(); ++wall) {
      const std::optional<Plane> plane = UnitPlane(walls.planes[wall]);
      if (!plane || edges[wall].size() < 2) continue;
      for (const GroundEdge& view : edges[wall])
        model_.wall_edges.push_back({static_cast<int>(model_.walls.size()), view});
      model_.walls.push_back(*plane);
    }
  }

  void AddObjectsOnGround(const ObjectMap& map, const std::map<ObjectId, ObjectFoot>& feet) {
    if (!model_.plane) return;
    for (std::size_t k = 0; k < model_.objects.size(); ++k) {
      const int node = model_.num_keyframes() + static_cast<int>(k);
      const ObjectId id = map.objects[model_.objects[k]].id;
      const auto foot = feet.find(id);
      const bool is_known = foot != feet.end() && std::isfinite(foot->second.bottom_m);
      const double gap_m = is_known ? GapToGround(k, foot->second.bottom_m) : 0;
      if (is_known && foot->second.supports.RestsElsewhere(gap_m, GraphOptions::kStandMaxGap_m))
        continue;
      model_.upright.push_back(node);
      if (is_known && std::abs(gap_m) > GraphOptions::kStandMaxGap_m)
        model_.not_standing.push_back(id);
    }
  }

  GraphModel Take() { return std::move(model_); }

 private:
  const Pose3& Node(int node) const {
    return model_.world_from_node[static_cast<std::size_t>(node)];
  }

  // Height of the object's bottom above the ground: median over the keyframes that saw both, where
  // drift has no part; else in the tracking world.
  double GapToGround(std::size_t object, double bottom_m) const {
    const Eigen::Vector3d bottom(0, 0, bottom_m);
    std::vector<double> gaps_m;
    for (const PoseEdge& edge : edges_of_object_[object]) {
      const auto seen =
          std::lower_bound(model_.ground_edges.begin(),
                           model_.ground_edges.end(),
                           edge.a,
                           [](const GroundEdge& ground, int node) { return ground.node < node; });
      if (seen == model_.ground_edges.end() || seen->node != edge.a) continue;
      gaps_m.push_back(seen->plane_camera.SignedDistance(edge.a_from_b * bottom));
    }
    if (gaps_m.empty()) {
      const int node = model_.num_keyframes() + static_cast<int>(object);
      return model_.plane->SignedDistance(Node(node) * bottom);
    }
    return Median(gaps_m);
  }

  // Edges of the object's usable views from their keyframes; `b` is left open.
  std::vector<PoseEdge> ObjectEdges(const MapObject& object) {
    const Vector6d floor = Floor(GraphOptions::kObjectFloor_m, GraphOptions::kObjectFloor_deg);
    std::vector<PoseEdge> edges;
    for (const ViewRegistration& view : object.views) {
      if (!view.ok) continue;
      const int node = KeyframeOfFrame(odometry_, view.frame);
      if (node < 0 || !IsFinite(view.camera_from_object) || !view.information.allFinite()) {
        ++model_.num_bad_edges;
        continue;
      }
      const Pose3 keyframe_from_camera =
          Node(node).Inverse() * odometry_.at(view.frame).world_from_camera;
      Pose3 keyframe_from_object = keyframe_from_camera * view.camera_from_object;
      Matrix6d information = view.information;
      if (view.yaw_free && IsFinite(object.world_from_object)) {
        const YawFreeMeasurement free = WithoutYaw(
            keyframe_from_object, information, Node(node).Inverse() * object.world_from_object);
        keyframe_from_object = free.a_from_b;
        information = free.information;
      }
      information = BalancedInformation<6>(information, GraphOptions::kObjectVarianceScale, floor);
      if (information.diagonal().maxCoeff() <= 0) {
        ++model_.num_bad_edges;
        continue;
      }
      edges.push_back({EdgeKind::kObject, node, -1, keyframe_from_object, information});
    }
    return edges;
  }

  Pose3 StartPose(const MapObject& object, const std::vector<PoseEdge>& edges) const {
    if (IsFinite(object.world_from_object)) return object.world_from_object;
    return Node(edges.front().a) * edges.front().a_from_b;
  }

  const Odometry& odometry_;
  GraphModel model_;
  std::vector<std::vector<PoseEdge>> edges_of_object_;  // per object node
};

}  // namespace

int PositionOf(const std::vector<FrameIdx>& keyframes, FrameIdx keyframe) {
  const auto it = std::lower_bound(keyframes.begin(), keyframes.end(), keyframe);
  if (it == keyframes.end() || *it != keyframe) return -1;
  return static_cast<int>(it - keyframes.begin());
}

int KeyframeOfFrame(const Trajectory& trajectory, FrameIdx frame) {
  const std::vector<FrameIdx>& keyframes = trajectory.keyframes;
  if (keyframes.empty() || !frame.valid() ||
      frame.value >= static_cast<int>(trajectory.frames.size())) {
    return -1;
  }
  const int itself = PositionOf(keyframes, frame);
  if (itself >= 0) return itself;
  const int own = PositionOf(keyframes, trajectory.at(frame).keyframe);
  if (own >= 0) return own;
  const auto after = std::upper_bound(keyframes.begin(), keyframes.end(), frame);
  return after == keyframes.begin() ? 0 : static_cast<int>(after - keyframes.begin()) - 1;
}

int NodeOfFrame(const GraphModel& model, const Trajectory& trajectory, FrameIdx frame) {
  const int keyframe = KeyframeOfFrame(trajectory, frame);
  return keyframe < 0 ? -1 : model.node_of_keyframe[static_cast<std::size_t>(keyframe)];
}

Result<GraphModel> BuildGraphModel(const Odometry& odometry,
                                   const Ground& ground,
                                   const ObjectMap& map,
                                   const Loops& loops,
                                   const GraphOptions& options,
                                   const GraphSurroundings& surroundings) {
  if (const Status status = CheckOdometry(odometry); !status.ok()) return status.error();
  const PathEdges path(odometry, loops, options);
  ModelBuilder builder(odometry);
  builder.TieLooseKeyframes(path);
  if (options.use_objects) builder.AddObjects(map);
  builder.AddGround(ground);
  builder.AddObjectsOnGround(map, surroundings.feet);
  if (options.use_walls) builder.AddWalls(surroundings.walls);
  const auto along_path = [&](const std::function<void(const PoseEdge&)>& use) {
    path.ForEach(use);
  };
  return Condensed(builder.Take(), along_path, odometry, options.max_keyframes);
}

}  // namespace deepslam::graph
