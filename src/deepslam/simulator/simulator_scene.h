// A scene as simulators load it.
#pragma once

#include <string>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/shape/rigid_body.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::simulator {

// A thing that is seen and collides. Its pieces may be none: then it is seen alone.
struct SimulatedThing {
  std::string name;  // any; becomes an identifier (core/identifiers.h)
  std::string class_name;
  Pose3 world_from_thing;      // world: z up, floor at z = 0
  TriangleMesh mesh;           // frame of the thing, m; may be empty
  Rgb8 colour{160, 160, 160};  // sRGB
  double opacity = 1;
  RigidBody body;
};

struct SimulatorScene {
  std::vector<SimulatedThing> things;
  bool has_floor = true;   // an endless one at z = 0
  std::string provenance;  // one line, for a comment
};

}  // namespace deepslam::simulator
