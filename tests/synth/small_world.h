// A small room with one box in it, small enough to be rendered within a unit test.
#pragma once

#include "deepslam/synth/world.h"
#include "support/box_meshes.h"

namespace deepslam::synth {

inline constexpr double kBoxSizeM = 0.8;

// A cube of 0.8 m, 12 faces, grey.
inline FurnitureModel BoxModel() {
  FurnitureModel model;
  model.mesh = testing_support::BoxMesh(Eigen::Vector3d::Constant(kBoxSizeM).cast<float>());
  model.mesh.colours.assign(model.mesh.vertices.size(), {150, 100, 60});
  model.size_m = Eigen::Vector3d::Constant(kBoxSizeM);
  return model;
}

// Things stand on tables.
inline ClassTable Classes() {
  ClassTable table;
  table.classes.resize(1);
  table.classes[0].name = "table";
  table.classes[0].traits.support_plane = true;
  return table;
}

inline SceneDescription SmallScene() {
  SceneDescription scene;
  scene.seed = 3;
  scene.num_frames = 6;
  scene.frames_per_s = 10;
  scene.camera = {80, 60, 65, 65, 39.5, 29.5};
  scene.room_size_m = {4, 4, 2.5};
  scene.num_posters = 2;
  scene.lights = {{{0.5, 0.5, 2.4}, 0.5, 2.0}};
  scene.objects = {{"table", "box", {0, 0}, 20, 7, std::nullopt}};
  scene.orbit.radius_m = 1.6;
  scene.orbit.sweep_deg = 60;
  return scene;
}

}  // namespace deepslam::synth
