// A small room with one box in it, small enough to be rendered within a unit test.
#pragma once

#include "deepslam/synth/world.h"

namespace deepslam::synth {

inline constexpr double kBoxSizeM = 0.8;

// A cube of 0.8 m, 12 faces, grey.
inline FurnitureModel BoxModel() {
  FurnitureModel model;
  const auto h = static_cast<float>(kBoxSizeM / 2);
  for (int corner = 0; corner < 8; ++corner) {
    model.mesh.vertices.emplace_back(corner & 1 ? h : -h, corner & 2 ? h : -h, corner & 4 ? h : -h);
    model.mesh.colours.push_back({150, 100, 60});
  }
  model.mesh.faces = {{0, 2, 1},
                      {1, 2, 3},
                      {4, 5, 6},
                      {5, 7, 6},
                      {0, 1, 4},
                      {1, 5, 4},
                      {2, 6, 3},
                      {3, 6, 7},
                      {0, 4, 2},
                      {2, 4, 6},
                      {1, 3, 5},
                      {3, 7, 5}};
  model.size_m = Eigen::Vector3d::Constant(kBoxSizeM);
  return model;
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
