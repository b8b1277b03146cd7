#include "deepslam/graph/object_graph.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>

#include "deepslam/core/angles.h"
#include "deepslam/graph/g2o.h"
#include "deepslam/graph/graph_model.h"
#include "deepslam/graph/gravity_world.h"

namespace deepslam::graph {
namespace {

// More than registration is off by: furniture stands upright.
constexpr double kNotedTilt_deg = 5.0;

Pose3 Blend(const Pose3& a, const Pose3& b, double share_of_b) {
  return {a.rotation.slerp(share_of_b, b.rotation).normalized(),
          (1.0 - share_of_b) * a.translation_m + share_of_b * b.translation_m};
}

// New tracking-world poses of every frame, from the moved keyframes.
std::vector<Pose3> CarryFrames(const Odometry& odometry,
                               const GraphModel& model,
                               bool interpolate) {
  const auto carried = [&](const TrackedFrame& frame, int node) {
    const Pose3& before =
        odometry.at(model.keyframes[static_cast<std::size_t>(node)]).world_from_camera;
    return model.world_from_node[static_cast<std::size_t>(node)] *
           (before.Inverse() * frame.world_from_camera);
  };
  std::vector<Pose3> poses;
  poses.reserve(odometry.frames.size());
  for (const TrackedFrame& frame : odometry.frames) {
    const int node = NodeOfFrame(model, odometry, frame.frame);
    if (node < 0) {
      poses.push_back(frame.world_from_camera);
      continue;
    }
    const Pose3 rigid = carried(frame, node);
    const int here = model.blend_from[static_cast<std::size_t>(node)].value;
    const bool between = node + 1 < model.num_keyframes() && frame.frame.value > here &&
                         frame.frame < model.keyframes[static_cast<std::size_t>(node) + 1];
    if (!interpolate || !between) {
      poses.push_back(rigid);
      continue;
    }
    const int next = model.keyframes[static_cast<std::size_t>(node) + 1].value;
    const double share = static_cast<double>(frame.frame.value - here) / (next - here);
    poses.push_back(Blend(rigid, carried(frame, node + 1), share));
  }
  return poses;
}

// The view an object without usable views hangs on; nullptr without any.
const ViewRegistration* BestView(const Odometry& odometry, const MapObject& object) {
  const ViewRegistration* best = nullptr;
  for (const ViewRegistration& view : object.views) {
    if (KeyframeOfFrame(odometry, view.frame) < 0) continue;
    if (best == nullptr || view.inlier_share > best->inlier_share) best = &view;
  }
  return best;
}

std::vector<Pose3> CarryObjects(const Odometry& odometry,
                                const ObjectMap& map,
                                const GraphModel& model,
                                const std::vector<Pose3>& cameras) {
  std::vector<Pose3> poses;
  for (const MapObject& object : map.objects) {
    Pose3 pose = object.world_from_object;
    const ViewRegistration* view = BestView(odometry, object);
    if (!odometry.keyframes.empty()) {
      const int k = view == nullptr ? 0 : KeyframeOfFrame(odometry, view->frame);
      const FrameIdx keyframe = odometry.keyframes[static_cast<std::size_t>(k)];
      const Pose3& before = odometry.at(keyframe).world_from_camera;
      pose = cameras[static_cast<std::size_t>(keyframe.value)] * (before.Inverse() * pose);
    }
    poses.push_back(pose);
  }
  for (std::size_t k = 0; k < model.objects.size(); ++k) {
    poses[model.objects[k]] =
        model.world_from_node[static_cast<std::size_t>(model.num_keyframes()) + k];
  }
  return poses;
}

void AddNote(MapObject& object, const std::string& note) {
  object.note += object.note.empty() ? note : "; " + note;
}

std::string Number(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof(buffer), "%.1f", value);
  return buffer;
}

// Doubts about how objects stand in the gravity-aligned world; returns the largest tilt.
double NoteHowObjectsStand(const GraphModel& model, ObjectMap& map) {
  double largest_deg = 0;
  for (MapObject& object : map.objects) {
    const Eigen::Vector3d up = object.world_from_object.rotation * Eigen::Vector3d::UnitZ();
    const double tilt_deg = std::atan2(up.head<2>().norm(), up.z()) * kDegPerRad;
    if (std::isfinite(tilt_deg)) largest_deg = std::max(largest_deg, tilt_deg);
    if (tilt_deg > kNotedTilt_deg) AddNote(object, "leans " + Number(tilt_deg) + " deg");
    if (std::find(model.not_standing.begin(), model.not_standing.end(), object.id) !=
        model.not_standing.end()) {
      AddNote(object, "does not stand on the ground");
    }
  }
  return largest_deg;
}

void CompleteMessage(const GraphModel& model, double tilt_deg, OptimizationSummary& summary) {
  if (model.num_bad_edges > 0) {
    summary.message += "; " + std::to_string(model.num_bad_edges) + " unusable edges left out";
  }
  if (model.num_ties > 0) {
    summary.message += "; " + std::to_string(model.num_ties) +
                       " keyframes without measurements tied by their tracked pose";
  }
  if (model.node_of_keyframe.size() > model.keyframes.size()) {
    summary.message += "; " + std::to_string(model.node_of_keyframe.size()) +
                       " keyframes solved as " + std::to_string(model.keyframes.size());
  }
  if (model.plane) summary.message += "; largest tilt of an object " + Number(tilt_deg) + " deg";
}

G2oGraph ToG2oGraph(const GraphModel& model, const ObjectMap& map) {
  G2oGraph graph;
  std::vector<int> ids;
  for (const FrameIdx keyframe : model.keyframes) ids.push_back(keyframe.value);
  for (const std::size_t k : model.objects) {
    ids.push_back(kObjectVertexOffset + map.objects[k].id.value);
  }
  const auto id = [&ids](int node) { return ids[static_cast<std::size_t>(node)]; };
  for (std::size_t k = 0; k < ids.size(); ++k) {
    graph.vertices.emplace(ids[k], model.world_from_node[k]);
  }
  if (!ids.empty()) graph.fixed.push_back(ids.front());
  for (const PoseEdge& edge : model.pose_edges) {
    const double lambda = edge.kind == EdgeKind::kObject ? 1.0 : GraphOptions::kLambdaOdometry;
    graph.edges.push_back(
        {id(edge.a), id(edge.b), edge.a_from_b, lambda * edge.weight * edge.information});
  }
  graph.plane = model.plane;
  for (const GroundEdge& edge : model.ground_edges) {
    graph.plane_edges.push_back(
        {id(edge.node), edge.plane_camera, GraphOptions::kLambdaGround * edge.information});
  }
  for (const int node : model.upright) graph.upright[id(node)] = GraphOptions::kLambdaUpright;
  return graph;
}

// The model's nodes at the poses of a finished optimisation.
Status MoveTo(const OptimizedMap& after, const ObjectMap& map, GraphModel& model) {
  if (after.map.objects.size() != map.objects.size()) {
    return InvalidInput("the optimised map has other objects than the graph");
  }
  for (std::size_t k = 0; k < model.keyframes.size(); ++k) {
    const auto frame = static_cast<std::size_t>(model.keyframes[k].value);
    if (frame >= after.frames.size()) {
      return InvalidInput("the optimised map lacks keyframe " + std::to_string(frame));
    }
    model.world_from_node[k] = after.frames[frame].world_from_camera;
  }
  for (std::size_t k = 0; k < model.objects.size(); ++k) {
    model.world_from_node[model.keyframes.size() + k] =
        after.map.objects[model.objects[k]].world_from_object;
  }
  if (model.plane) model.plane = after.ground_world;
  return Ok();
}

}  // namespace

void Describe(OptionsVisitor& visitor, GraphOptions& options) {
  static constexpr std::array<std::string_view, 3> kLosses = {"none", "huber", "cauchy"};
  visitor.Choice("object_loss", options.object_loss, kLosses, "robust loss on r_io");
  visitor.Choice("loop_loss", options.loop_loss, kLosses, "robust loss on loop edges");
  visitor.Choice("ground_loss", options.ground_loss, kLosses, "robust loss on r_pi");
  visitor.Field("loss_rounds",
                options.loss_rounds,
                {1, 8},
                "1",
                "rounds of shrinking loss width, each a quarter of the one before");
  visitor.Field("use_objects", options.use_objects, "objects enter the graph");
  visitor.Field("use_walls",
                options.use_walls,
                "walls of the layout enter the graph: one plane in all keyframes that saw it");
  visitor.Field(
      "max_direct_keyframes",
      options.max_direct_keyframes,
      {0, 1e6},
      "1",
      "graphs of more are solved by conjugate gradients, in memory that grows with edges");
  visitor.Field("max_keyframes",
                options.max_keyframes,
                {2, 1e6},
                "1",
                "of paths with more, keyframes that follow each other are one in the graph");
  visitor.Field("interpolate_frames",
                options.interpolate_frames,
                "frames between keyframes blend the corrections of both; else rigid");
}

Result<OptimizedMap> OptimizeGraph(const Odometry& odometry,
                                   const Ground& ground,
                                   const ObjectMap& map,
                                   const Loops& loops,
                                   const GraphOptions& options,
                                   const GraphSurroundings& surroundings) {
  Result<GraphModel> built = BuildGraphModel(odometry, ground, map, loops, options, surroundings);
  if (!built.ok()) return built.error();
  GraphModel& model = *built;

  OptimizedMap result;
  result.summary = SolveGraph(model, options);
  result.keyframes = odometry.keyframes;
  result.frames = odometry.frames;
  result.map = map;
  result.has_ground = model.plane.has_value();
  result.ground_world = Plane{};  // z = 0
  result.upright = ground.upright;

  const std::vector<Pose3> cameras = CarryFrames(odometry, model, options.interpolate_frames);
  const std::vector<Pose3> objects = CarryObjects(odometry, map, model, cameras);
  const Pose3 first = !model.keyframes.empty() ? model.world_from_node.front()
                      : cameras.empty()        ? Pose3{}
                                               : cameras.front();
  const Pose3 gravity_from_tracking =
      GravityFromTracking(first, model.plane, ground.upright.value_or(QuarterTurn::kNone));
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    result.frames[k].world_from_camera = gravity_from_tracking * cameras[k];
  }
  for (std::size_t k = 0; k < objects.size(); ++k) {
    result.map.objects[k].world_from_object = gravity_from_tracking * objects[k];
  }
  const double tilt_deg = model.plane ? NoteHowObjectsStand(model, result.map) : 0.0;
  CompleteMessage(model, tilt_deg, result.summary);
  return result;
}

Result<std::string> GraphToG2o(const Odometry& odometry,
                               const Ground& ground,
                               const ObjectMap& map,
                               const Loops& loops,
                               const GraphOptions& options,
                               const GraphSurroundings& surroundings,
                               const OptimizedMap* after) {
  Result<GraphModel> model = BuildGraphModel(odometry, ground, map, loops, options, surroundings);
  if (!model.ok()) return model.error();
  if (after != nullptr) {
    if (const Status moved = MoveTo(*after, map, *model); !moved.ok()) return moved.error();
  }
  return WriteG2o(ToG2oGraph(*model, map));
}

}  // namespace deepslam::graph
