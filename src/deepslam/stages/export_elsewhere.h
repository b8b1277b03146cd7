// What stage `export` writes for engines and simulators where it is asked to.
#pragma once

#include <span>

#include "deepslam/core/result.h"
#include "deepslam/gltf/scene_writer.h"
#include "deepslam/pipeline/stage.h"
#include "deepslam/scene/compact_map.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/scene/triangle_mesh.h"
#include "deepslam/stages/config.h"

namespace deepslam::stages {

// All of one map; they outlive it.
struct ExportedScene {
  const gltf::GltfScene& scene;
  const CompactMap& map;
  std::span<const TriangleMesh> meshes;
  const ClassTable& classes;
};

// scene.usdz, scene.usda, simulator/.
[[nodiscard]] Status WriteElsewhere(pipeline::StageContext& context,
                                    const ExportedScene& exported,
                                    const Config& config);

}  // namespace deepslam::stages
