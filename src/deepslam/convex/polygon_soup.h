// The surface of a mesh in parts that planes cut it into, each with what closes it.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::convex {

struct CutPlane {
  Eigen::Vector3f normal = Eigen::Vector3f::UnitX();
  float offset = 0;  // below: normal . x <= offset
};

// Polygons that share points.
struct PolygonSoup {
  std::vector<Eigen::Vector3f> points;
  std::vector<std::uint32_t> corners;  // of one polygon after the other
  std::vector<std::uint32_t> sizes;    // how many corners each has
};

// A part of a closed surface. `caps` are triangles that close it along the planes of the cuts: as a
// sum of oriented areas, in which what reaches beyond the part cancels, so that the volume is right
// and the points alone say nothing.
struct SurfacePart {
  PolygonSoup surface;
  PolygonSoup caps;
};

[[nodiscard]] SurfacePart WholeOf(const TriangleMesh& closed);

// What lies below the plane and what above.
[[nodiscard]] std::pair<SurfacePart, SurfacePart> Split(const SurfacePart& part,
                                                        const CutPlane& plane);

[[nodiscard]] double VolumeOf(const SurfacePart& part);

}  // namespace deepslam::convex
