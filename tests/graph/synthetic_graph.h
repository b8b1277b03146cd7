// A walk round a room with chairs: true poses, and what odometry, ground and registration would
// measure of them.
#pragma once

#include <cmath>
#include <map>
#include <numbers>

#include "deepslam/core/random.h"
#include "deepslam/graph/object_graph.h"

namespace deepslam::graph::testing_support {

struct Noise {
  double translation_m = 0;  // per odometry edge
  double rotation_rad = 0;
  double object_m = 0;  // per view
  double object_rad = 0;
};

struct World {
  Odometry odometry;  // drifted
  Ground ground;
  ObjectMap map;
  Loops loops;
  std::map<ObjectId, ObjectFoot> feet;
  // Gravity-aligned truth: z up, ground z = 0.
  std::vector<Pose3> world_from_camera;
  std::vector<Pose3> world_from_object;
};

inline Pose3 Disturbance(Random& random, double translation_m, double rotation_rad) {
  Vector6d v;
  for (int k = 0; k < 3; ++k) v[k] = translation_m * random.Normal();
  for (int k = 3; k < 6; ++k) v[k] = rotation_rad * random.Normal();
  return V2t(v);
}

inline Matrix6d Information(double translation_m, double rotation_rad) {
  Vector6d deviation;
  deviation << Eigen::Vector3d::Constant(std::max(translation_m, 1e-4)),
      Eigen::Vector3d::Constant(std::max(rotation_rad, 1e-4));
  return deviation.cwiseAbs2().cwiseInverse().asDiagonal();
}

// Camera at `position_m` looking along `yaw_rad`, `down_rad` below the horizon.
inline Pose3 LookAlong(const Eigen::Vector3d& position_m, double yaw_rad, double down_rad) {
  const Eigen::Vector3d view(std::cos(down_rad) * std::cos(yaw_rad),
                             std::cos(down_rad) * std::sin(yaw_rad),
                             -std::sin(down_rad));
  Eigen::Matrix3d axes;
  axes.col(2) = view;
  axes.col(0) = view.cross(Eigen::Vector3d::UnitZ()).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return {Eigen::Quaterniond(axes).normalized(), position_m};
}

// The first camera stands at (0, 0, 1.4) and looks along x, so that the truth is the world
// OptimizeGraph makes. Every frame is a keyframe; object k is seen by the keyframes with (frame /
// 4) % num_objects == k, in every lap.
inline World MakeWorld(
    int num_frames, int num_objects, double laps, const Noise& noise, std::uint64_t seed = 1) {
  World world;
  Random random(seed);
  const double radius_m = 3.0;
  for (int k = 0; k < num_frames; ++k) {
    const double angle = 2 * std::numbers::pi * laps * k / num_frames;
    const Eigen::Vector3d position_m(radius_m * std::sin(angle),
                                     radius_m * (1 - std::cos(angle)),
                                     1.4 + 0.1 * std::sin(5 * angle));
    world.world_from_camera.push_back(
        LookAlong(position_m, angle, 0.3 + 0.1 * std::sin(3 * angle)));
  }
  for (int k = 0; k < num_objects; ++k) {
    const double angle = 2 * std::numbers::pi * k / num_objects;
    const Eigen::Quaterniond yaw(Eigen::AngleAxisd(0.7 * k, Eigen::Vector3d::UnitZ()));
    world.world_from_object.push_back(
        {yaw, Eigen::Vector3d(4 * std::sin(angle), 3 - 4 * std::cos(angle), 0.45)});
  }
  // Tracking world: the first camera.
  Pose3 tracked;
  for (int k = 0; k < num_frames; ++k) {
    if (k > 0) {
      const auto b = static_cast<std::size_t>(k);
      const Pose3 measured = world.world_from_camera[b - 1].Inverse() * world.world_from_camera[b] *
                             Disturbance(random, noise.translation_m, noise.rotation_rad);
      tracked = tracked * measured;
      world.odometry.edges.push_back({FrameIdx{k - 1},
                                      FrameIdx{k},
                                      measured,
                                      Information(noise.translation_m, noise.rotation_rad),
                                      false});
    }
    world.odometry.keyframes.push_back(FrameIdx{k});
    world.odometry.frames.push_back(
        {FrameIdx{k}, 0.1 * k, tracked, TrackingStatus::kTracked, FrameIdx{k}, 0.002, 0.9});
    const Plane ground_camera =
        Transformed(world.world_from_camera[static_cast<std::size_t>(k)].Inverse(), Plane{});
    const Eigen::Vector3d deviation(0.002, 0.002, 0.005);
    world.ground.observations.push_back(
        {FrameIdx{k}, ground_camera, deviation.cwiseAbs2().cwiseInverse().asDiagonal(), 10000});
  }
  if (num_frames > 0) world.ground.plane_world = world.ground.observations.front().plane_camera;
  for (int k = 0; k < num_objects; ++k) {
    const Pose3& truth = world.world_from_object[static_cast<std::size_t>(k)];
    MapObject object;
    object.id = ObjectId{k};
    object.class_name = "chair";
    object.scale_m = 0.9;
    for (int f = 0; f < num_frames; ++f) {
      if ((f / 4) % num_objects != k) continue;
      ViewRegistration view;
      view.view = DetectionId{f};
      view.frame = FrameIdx{f};
      view.ok = true;
      view.inlier_share = 0.8;
      view.camera_from_object = world.world_from_camera[static_cast<std::size_t>(f)].Inverse() *
                                truth * Disturbance(random, noise.object_m, noise.object_rad);
      view.information = Information(noise.object_m, noise.object_rad);
      object.views.push_back(view);
    }
    if (!object.views.empty()) {
      const ViewRegistration& view = object.views.front();
      object.world_from_object =
          world.odometry.at(view.frame).world_from_camera * view.camera_from_object;
    }
    world.map.objects.push_back(object);
    world.feet[object.id].bottom_m = -0.45;
  }
  return world;
}

// Edges over more than one keyframe, and loops to every earlier round of so many keyframes, or to
// two of them, by turns.
struct RoundEdges {
  int keyframes_per_round = 0;
  std::vector<int> gaps;
  bool two_loops_each = false;
};

inline void AddMeasured(const RoundEdges& edges,
                        const Noise& noise,
                        std::uint64_t seed,
                        World& world) {
  Random random(seed, "rounds", 0);
  const auto measured = [&](int i, int j) {
    return RelativePose{FrameIdx{i},
                        FrameIdx{j},
                        world.world_from_camera[static_cast<std::size_t>(i)].Inverse() *
                            world.world_from_camera[static_cast<std::size_t>(j)] *
                            Disturbance(random, noise.translation_m, noise.rotation_rad),
                        Information(noise.translation_m, noise.rotation_rad),
                        false};
  };
  const int num_frames = static_cast<int>(world.world_from_camera.size());
  for (int j = 0; j < num_frames; ++j) {
    for (const int gap : edges.gaps)
      if (j >= gap) world.odometry.edges.push_back(measured(j - gap, j));
    const int round = j / edges.keyframes_per_round;
    for (int back = 1; back <= round; ++back) {
      const bool in_turn = back == 1 + j % round || back == 1 + (7 * j + 3) % round;
      if (in_turn || !edges.two_loops_each)
        world.loops.edges.push_back(measured(j - back * edges.keyframes_per_round, j));
    }
  }
}

// As stage `track` leaves a path: what is measured within a stretch is settled, rounds are not.
inline void RefineLocally(World& world) {
  Odometry& odometry = world.odometry;
  GraphOptions whole;
  whole.max_keyframes = static_cast<int>(odometry.keyframes.size());
  const OptimizedMap refined = *OptimizeGraph(odometry, {}, {}, {}, whole);
  const Pose3 tracking_from_refined = odometry.frames.front().world_from_camera *
                                      refined.frames.front().world_from_camera.Inverse();
  for (std::size_t k = 0; k < odometry.frames.size(); ++k) {
    odometry.frames[k].world_from_camera =
        tracking_from_refined * refined.frames[k].world_from_camera;
  }
}

inline double TrajectoryError(const std::vector<TrackedFrame>& frames, const World& world) {
  double sum = 0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    sum += (frames[k].world_from_camera.translation_m - world.world_from_camera[k].translation_m)
               .squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(frames.size()));
}

}  // namespace deepslam::graph::testing_support
