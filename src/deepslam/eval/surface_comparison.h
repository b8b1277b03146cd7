// How well a reconstructed surface covers the true one and how far it strays from it.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/result.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::eval {

inline constexpr std::string_view kSurfaceProtocol =
    "surface: 4 points per cm^2 by area, nearest point, F = 2 P R / (P + R)";

// Refuses meshes without faces, with faces that name a vertex that is not there, with vertices that
// are not finite, or without area. `name` is for the message.
[[nodiscard]] Status CheckTriangles(const TriangleMesh& mesh, std::string_view name);

// Points drawn evenly over the faces, one per `area_m2` of surface, placed by `b_from_mesh`. A
// function of mesh and seed alone. At most 4 million points: the density is lowered beyond.
[[nodiscard]] std::vector<Eigen::Vector3d> SampleSurface(const TriangleMesh& mesh,
                                                         const Pose3& b_from_mesh,
                                                         double area_m2,
                                                         std::uint64_t seed);

// Without the points that lie inside the solid that the mesh encloses when gaps narrower than 1/64
// of its size are closed: inner walls of CAD models, which no camera can see. `points_mesh` are in
// the frame of the mesh.
[[nodiscard]] std::vector<Eigen::Vector3d> OuterPoints(
    const TriangleMesh& mesh, std::span<const Eigen::Vector3d> points_mesh);

struct SurfaceComparison {
  std::int64_t num_estimated = 0;  // points
  std::int64_t num_true = 0;
  double accuracy = 0;        // share of estimated points within the threshold of the truth (P)
  double completeness = 0;    // share of true points within the threshold of the estimate (R)
  double f_score = 0;         // harmonic mean; 0 where both are 0
  double accuracy_m = 0;      // mean distance from the estimate to the truth
  double completeness_m = 0;  // mean distance from the truth to the estimate, capped as below
};
// Distances beyond 10 thresholds count as that much in the means, so that a missing object is a
// number. All shares are 0 where a side has no points.
[[nodiscard]] SurfaceComparison CompareSurfaces(std::span<const Eigen::Vector3d> estimated,
                                                std::span<const Eigen::Vector3d> truth,
                                                double threshold_m);

}  // namespace deepslam::eval
