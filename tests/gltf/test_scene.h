// Small scenes of closed solids.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>

#include "deepslam/gltf/scene_writer.h"
#include "support/box_meshes.h"

namespace deepslam::gltf {

// A box with its lower side at z = 0, metres, closed.
inline TriangleMesh BoxMesh(float x, float y, float z) {
  TriangleMesh mesh;
  testing_support::AddBox({-x, -y, 0}, {x, y, z}, mesh);
  return mesh;
}

inline GltfObject BoxObject(const std::string& class_name, int instance) {
  GltfObject object;
  object.name = class_name + "_0" + std::to_string(instance);
  object.class_name = class_name;
  object.instance = instance;
  object.score = 0.75;
  object.source = "retrieval";
  object.views = {3, 14, 15};
  object.mesh = BoxMesh(0.3F, 0.2F, 0.9F);
  object.world_from_object = {Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ())),
                              Eigen::Vector3d(1.0 * instance, 2, 0)};
  object.class_colour = {200, 80, 60};
  return object;
}

inline GltfScene SmallScene() {
  GltfScene scene;
  scene.objects = {BoxObject("chair", 1), BoxObject("chair", 2), BoxObject("table", 1)};
  for (std::size_t n = 0; n < 8; ++n) {
    scene.objects[1].mesh.colours.push_back({static_cast<std::uint8_t>(30 * n), 100, 50});
  }
  scene.objects[2].credit = "A. Maker, CC-BY 3.0";
  TriangleMesh ground;
  ground.vertices = {{-3, -3, 0}, {3, -3, 0}, {3, 3, 0}, {-3, 3, 0}};
  ground.faces = {{0, 1, 2}, {0, 2, 3}};
  scene.ground = ground;
  TriangleMesh room = ground;
  for (Eigen::Vector3f& p : room.vertices) p.z() = 0.5F * p.x();
  room.colours.assign(4, {90, 90, 90});
  scene.room = room;
  for (int n = 0; n < 10; ++n) {
    scene.trajectory_world_from_camera.push_back(
        {Eigen::Quaterniond::Identity(), {0.1 * n, 0, 1.5}});
  }
  scene.keyframes = {{0, scene.trajectory_world_from_camera[0]},
                     {9, scene.trajectory_world_from_camera[9]}};
  scene.camera = {640, 480, 525, 525, 319.5, 239.5};
  scene.provenance = {{"version", "0.1.0"}, {"capture", "00ff"}};
  return scene;
}

inline GltfOptions Plain() {
  GltfOptions options;
  options.draco = false;
  return options;
}

// The JSON chunk's text; and a GLB with that text replaced.
inline std::string JsonOf(const std::string& glb) {
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, 4);
  return glb.substr(20, length);
}

inline std::string WithJson(const std::string& glb, std::string json) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::string rest = glb.substr(20 + JsonOf(glb).size());
  const auto word = [](std::size_t value) {
    const auto v = static_cast<std::uint32_t>(value);
    std::string bytes(4, '\0');
    std::memcpy(bytes.data(), &v, 4);
    return bytes;
  };
  return glb.substr(0, 8) + word(20 + json.size() + rest.size()) + word(json.size()) + "JSON" +
         json + rest;
}

}  // namespace deepslam::gltf
