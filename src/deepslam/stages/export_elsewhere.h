// What stage `export` and `deepslam expand` write for engines and simulators where they are asked
// to.
#pragma once

#include <span>

#include "deepslam/core/result.h"
#include "deepslam/gltf/scene_writer.h"
#include "deepslam/scene/compact_map.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/scene/triangle_mesh.h"
#include "deepslam/simulator/simulator_files.h"
#include "deepslam/stages/config.h"

namespace deepslam::stages {

// All of one map; they outlive it.
struct ExportedScene {
  const gltf::GltfScene& scene;
  const CompactMap& map;
  std::span<const TriangleMesh> meshes;
  const ClassTable& classes;
};

// scene.usdz, scene.usda, simulator/: handed to `write` one after another, whose first error ends
// it.
[[nodiscard]] Status WriteElsewhere(const ExportedScene& exported,
                                    const Config& config,
                                    const simulator::WriteFile& write);

}  // namespace deepslam::stages
