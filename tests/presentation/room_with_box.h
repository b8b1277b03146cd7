// A finished map in memory: a floor, a wall, and a box of one metre on the floor, as one object
// whose shape is its own voxels.
#pragma once

#include <string>

#include "deepslam/core/sha256.h"
#include "deepslam/mesh/object_mesh.h"
#include "deepslam/presentation/compact_map.h"
#include "deepslam/presentation/finished_map.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/shape/binvox.h"
#include "deepslam/shape/voxel_code.h"
#include "support/box_world.h"
#include "support/voxel_shapes.h"

namespace deepslam::presentation {

inline const VoxelGrid& CubeGrid() {
  static const VoxelGrid kGrid = testing_support::Box(31, 31, 31);
  return kGrid;
}

// 1 m wide, by 62 voxels of 64.
inline constexpr double kCubeScaleM = 64.0 / 62;

inline ClassTable OneClass() {
  ClassTable classes;
  classes.classes.emplace_back();
  classes.classes.back().name = "cabinet";
  classes.classes.back().colour_rgb = {10, 20, 30};
  return classes;
}

// A square of the plane through `corner`, two triangles each `step_m` wide.
inline void AddSquare(const Eigen::Vector3f& corner,
                      const Eigen::Vector3f& along,
                      const Eigen::Vector3f& across,
                      int num_steps,
                      TriangleMesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  const auto side = static_cast<std::uint32_t>(num_steps + 1);
  for (std::uint32_t i = 0; i < side; ++i) {
    for (std::uint32_t j = 0; j < side; ++j) {
      const auto share = [&](std::uint32_t n) {
        return static_cast<float>(n) / static_cast<float>(num_steps);
      };
      mesh.vertices.emplace_back(corner + share(i) * along + share(j) * across);
      mesh.colours.push_back({90, 90, 90});
    }
  }
  for (std::uint32_t i = 0; i + 1 < side; ++i) {
    for (std::uint32_t j = 0; j + 1 < side; ++j) {
      const std::uint32_t a = first + i * side + j;
      mesh.faces.push_back({a, a + side, a + 1});
      mesh.faces.push_back({a + 1, a + side, a + side + 1});
    }
  }
}

inline FinishedMap RoomWithBox() {
  FinishedMap finished;
  OptimizedMap& map = finished.map;
  map.has_ground = true;
  map.ground_world = {Eigen::Vector3d::UnitZ(), 0};
  map.summary.converged = true;
  const std::vector<Pose3> poses = testing_support::Orbit({0, 0, 0.5}, 2.5, 1.5, -20, 10, 5);
  for (std::size_t n = 0; n < poses.size(); ++n) {
    TrackedFrame frame;
    frame.frame = FrameIdx{static_cast<int>(n)};
    frame.keyframe = frame.frame;
    frame.world_from_camera = poses[n];
    map.frames.push_back(frame);
    map.keyframes.push_back(frame.frame);
  }
  MapObject object;
  object.id = ObjectId{3};
  object.class_name = "cabinet";
  object.chosen = CandidateId{5};
  object.source = CandidateSource::kFused;
  object.model = "fused_3";
  object.scale_m = kCubeScaleM;
  object.world_from_object = {Eigen::Quaterniond::Identity(), {0, 0, 0.5}};
  object.confidence = 0.9;
  object.views.resize(2);
  object.views[0].view = DetectionId{0};
  object.views[0].frame = FrameIdx{0};
  object.views[1].view = DetectionId{2};
  object.views[1].frame = FrameIdx{2};
  object.scores.resize(1);
  object.scores[0].candidate = object.chosen;
  map.map.objects = {object};
  finished.meshes = {*mesh::MakeObjectMesh(CubeGrid(), kCubeScaleM, {})};
  finished.meshes[0].colours.assign(finished.meshes[0].vertices.size(), Rgb8{200, 0, 0});
  AddSquare({-3, -3, 0}, {6, 0, 0}, {0, 6, 0}, 60, finished.room_world);  // floor
  AddSquare({-3, 3, 0}, {6, 0, 0}, {0, 0, 2}, 60, finished.room_world);   // wall
  // What segmentation left of the box to the room: its upper side.
  AddSquare({-0.4F, -0.4F, 1.01F}, {0.8F, 0, 0}, {0, 0.8F, 0}, 20, finished.room_world);
  return finished;
}

inline RunIdentity SomeRun() { return {"0.1.0", "kitchen", "ab12"}; }

inline ShapeCodes CodesOfRoomWithBox() {
  ShapeCodes codes;
  codes.models["fused_3"] = {Sha256Hex(shape::WriteBinvox(CubeGrid())),
                             shape::EncodeVoxels(CubeGrid())};
  return codes;
}

}  // namespace deepslam::presentation
