// What a run ends with, as scene, compact map and report show it.
#pragma once

#include <string>
#include <vector>

#include "deepslam/scene/layout.h"
#include "deepslam/scene/optimized_map.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::presentation {

struct FinishedMap {
  OptimizedMap map;
  // One per object of the map, in its order: metric object frame, m; empty: without a surface.
  std::vector<TriangleMesh> meshes;
  TriangleMesh room_world;  // the measured room, m; empty where nothing was fused
  Layout layout_world;      // the room itself
};

// By what and of what a map was made.
struct RunIdentity {
  std::string tool_version;
  std::string capture_name;
  std::string capture_sha256;
};

}  // namespace deepslam::presentation
