// A room traversed twice: objects as boxes of points, walls and shelves around them, and drift
// between the traversals.
#pragma once

#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "deepslam/core/random.h"
#include "deepslam/loop/constellation.h"
#include "deepslam/scene/measured_parts.h"

namespace deepslam::loop::testing_support {

struct Furniture {
  std::string class_name;
  double x_m = 0;
  double y_m = 0;
  double yaw_rad = 0;
};

struct Scene {
  ObjectMap map;
  Association association;
  Odometry odometry;
  LoopEvidence evidence;
};

inline Pose3 Yawed(double x_m, double y_m, double z_m, double yaw_rad) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ())),
          {x_m, y_m, z_m}};
}

// An L-shaped thing like a chair: seat and back, so that its yaw shows.
inline std::vector<Eigen::Vector3f> ChairPoints() {
  std::vector<Eigen::Vector3f> points;
  for (float a = -0.25F; a <= 0.25F; a += 0.025F) {
    for (float b = -0.25F; b <= 0.25F; b += 0.025F) {
      points.emplace_back(a, b, 0.0F);
      points.emplace_back(-0.25F, a, 0.25F + b);
      if (std::abs(a) > 0.2F && std::abs(b) > 0.2F) {
        for (float z = -0.45F; z < 0; z += 0.025F) points.emplace_back(a, b, z);
      }
    }
  }
  return points;
}

inline std::vector<Eigen::Vector3f> Moved(const std::vector<Eigen::Vector3f>& points,
                                          const Pose3& b_from_a) {
  std::vector<Eigen::Vector3f> moved;
  for (const Eigen::Vector3f& p : points)
    moved.push_back((b_from_a * p.cast<double>()).cast<float>());
  return moved;
}

// Clutter at random places of a room of `size_m`, fixed by the seed: posts and boards above the
// floor.
inline std::vector<Eigen::Vector3f> Clutter(std::uint64_t seed, double size_m) {
  Random random(seed);
  std::vector<Eigen::Vector3f> points;
  for (int k = 0; k < 40; ++k) {
    const Eigen::Vector3d corner(
        random.Uniform(-size_m, size_m), random.Uniform(-size_m, size_m), random.Uniform(0.2, 1.5));
    const double yaw = random.Uniform(0, 6.28);
    for (int a = 0; a < 12; ++a) {
      for (int b = 0; b < 12; ++b) {
        const Eigen::Vector3d p = corner +
                                  0.04 * a * Eigen::Vector3d(std::cos(yaw), std::sin(yaw), 0) +
                                  0.04 * b * Eigen::Vector3d::UnitZ();
        points.push_back(p.cast<float>());
      }
    }
  }
  return points;
}

// The camera walks `path_m` along x over `num_frames` frames, every tenth a keyframe.
inline Odometry Walk(int num_frames, double path_m) {
  Odometry odometry;
  for (int k = 0; k < num_frames; ++k) {
    TrackedFrame frame;
    frame.frame = FrameIdx{k};
    frame.world_from_camera.translation_m.x() = path_m * k / (num_frames - 1);
    frame.keyframe = FrameIdx{k - k % 10};
    odometry.frames.push_back(frame);
    if (k % 10 == 0) odometry.keyframes.push_back(FrameIdx{k});
  }
  return odometry;
}

// Adds what one traversal maps: each object seen in frames [first_frame, first_frame + 20), its
// place off by `noise_m`, everything moved by the drift of that traversal.
inline void AddTraversal(Scene& scene,
                         const std::vector<Furniture>& furniture,
                         int first_frame,
                         const Pose3& drifted_from_true,
                         const std::vector<Eigen::Vector3f>& room,
                         double noise_m = 0.03) {
  Random random(static_cast<std::uint64_t>(first_frame) + 17);
  for (const Furniture& item : furniture) {
    const ObjectId id{static_cast<int>(scene.map.objects.size())};
    const Pose3 truth = drifted_from_true * Yawed(item.x_m, item.y_m, 0.45, item.yaw_rad);
    MapObject object;
    object.id = id;
    object.class_name = item.class_name;
    object.scale_m = 0.95;
    object.world_from_object = truth;
    for (int k = 0; k < 3; ++k)
      object.world_from_object.translation_m[k] += noise_m * random.Uniform(-1, 1);
    ObjectTrack track{id, item.class_name, {}, ""};
    for (int frame = first_frame; frame < first_frame + 20; ++frame) {
      track.members.push_back(
          {DetectionId{100 * frame + id.value}, FrameIdx{frame}, 3, 0.01, "vote"});
      ViewRegistration view;
      view.frame = FrameIdx{frame};
      view.ok = true;
      view.inlier_share = 0.8;
      object.views.push_back(view);
    }
    ObjectEvidence evidence;
    evidence.depth_points_world = Moved(ChairPoints(), truth);
    evidence.model_points_world = Moved(ChairPoints(), object.world_from_object);
    evidence.surroundings_world = Moved(room, drifted_from_true);
    scene.evidence[id] = evidence;
    scene.map.objects.push_back(object);
    scene.association.tracks.push_back(track);
  }
}

inline ClassTable Classes() {
  ClassTable table;
  table.classes.resize(2);
  table.classes[0].name = "chair";
  table.classes[1].name = "table";
  table.classes[1].traits.yaw_free = true;
  return table;
}

inline FoundConstellations FindIn(const Scene& scene,
                                  const LoopOptions& options,
                                  const ClassTable& classes = Classes()) {
  return FindConstellations({scene.map, scene.association, classes, scene.odometry}, options);
}

inline Loops Detect(const Scene& scene, const LoopOptions& options = {}) {
  std::vector<Constellation> verified;
  const ClassTable classes = Classes();
  const std::vector<int> parts = PartsOfFrames(scene.odometry, JoinsOf(scene.odometry));
  const FoundConstellations found =
      FindConstellations({scene.map, scene.association, classes, scene.odometry, parts}, options);
  for (const Constellation& proposed : found.constellations)
    verified.push_back(VerifyConstellation(proposed, scene.map, scene.evidence, options));
  return AcceptLoops(verified, scene.map, scene.association, scene.odometry);
}

inline std::set<std::pair<int, int>> Merged(const Loops& loops) {
  std::set<std::pair<int, int>> merged;
  for (const ObjectMerge& merge : loops.merges)
    merged.emplace(merge.kept.value, merge.merged.value);
  return merged;
}

}  // namespace deepslam::loop::testing_support
