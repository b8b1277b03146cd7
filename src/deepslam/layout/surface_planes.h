// Flat parts of a coarse surface (region growing: CGAL, Shape_detection).
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "deepslam/geometry/plane.h"
#include "deepslam/scene/coarse_surface.h"

namespace deepslam::layout {

struct PlaneOptions {
  // Two voxels: what a Kinect's noise at 4 m leaves of a wall after fusion.
  double max_distance_m = 0.06;
  // Between a vertex's smoothed normal and the plane's; marching cubes turn normals by the noise of
  // each voxel, and what meets a wall at an angle turns by more.
  double max_angle_deg = 25;
  double min_area_m2 = 0.08;  // of a flat part; walls are put together of several
};

struct SurfacePlane {
  Plane plane;  // normal towards the free side
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double area_m2 = 0;
  double rms_m = 0;                     // of the vertices' distances
  std::vector<std::uint32_t> vertices;  // ascending
};

// A third of the faces around each vertex.
[[nodiscard]] std::vector<double> VertexAreas(const TriangleMesh& mesh);

// By area, largest first. Each vertex lies in one plane at most. `areas_m2` as VertexAreas gives
// it.
[[nodiscard]] std::vector<SurfacePlane> FindPlanes(const CoarseSurface& surface,
                                                   const std::vector<double>& areas_m2,
                                                   const PlaneOptions& options);

}  // namespace deepslam::layout
