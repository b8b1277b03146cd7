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
  // The sensor's depth at a vertex may differ by this much: noise at 4 m and the model's error.
  static constexpr double kDepthTolerance_m = 0.04;
  // Between the vertex's normal and the ray to the camera; beyond, a pixel covers four times its
  // width.
  static constexpr double kMaxViewAngle_deg = 75;
  // A step in depth larger than this next to the pixel: the colour may be the background's.
  static constexpr double kMaxEdgeStep_m = 0.05;
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
