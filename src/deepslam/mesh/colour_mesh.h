// Vertex colours from the frames that saw an object.
#pragma once

#include <span>

#include "deepslam/core/image.h"
#include "deepslam/core/options.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/object_view.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::mesh {

struct ColourOptions {
  double depth_tolerance_m =
      0.04;  // the sensor's depth at a vertex may differ by this much: noise and model error
  double max_view_angle_deg =
      75;  // between the vertex's normal and the ray to the camera; beyond it colours smear
  double max_edge_step_m =
      0.05;  // a depth step larger than this next to the pixel: colour may be the background's
  bool segment_only = true;  // pixels off the object's segment give no colour
};
void Describe(OptionsVisitor& visitor, ColourOptions& options);

struct ColourReport {
  int num_seen = 0;    // vertices with a colour of their own
  int num_spread = 0;  // vertices that took their neighbours' colour
};

// The mesh with one colour per vertex: the weighted median over the views that see it (weight:
// cosine of the view angle over squared distance). A vertex that no view sees takes its neighbours'
// colour when one is seen nearby along the surface, else the median of all seen vertices;
// `fallback` when no vertex is seen at all. `world_from_object` and the views' `world_from_camera`
// must be in the same world.
[[nodiscard]] TriangleMesh ColourMesh(const TriangleMesh& mesh_object_m,
                                      std::span<const ObjectView> views,
                                      const Pose3& world_from_object,
                                      Rgb8 fallback = {160, 160, 160},
                                      const ColourOptions& options = {},
                                      ColourReport* report = nullptr);

}  // namespace deepslam::mesh
