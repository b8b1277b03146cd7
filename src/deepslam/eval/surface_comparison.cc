#include "deepslam/eval/surface_comparison.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>

#include "deepslam/core/random.h"
#include "deepslam/eval/nearest_points.h"
#include "deepslam/geometry/box.h"
#include "deepslam/shape/shape_model.h"
#include "deepslam/shape/voxelize.h"

namespace deepslam::eval {
namespace {

// Bounds memory: very large meshes are sampled more coarsely.
constexpr double kMaxSurfaceSamples = 4e6;
constexpr double kCapThresholds = 10;  // one stray piece far off must not make the mean
// Voxels that a point may lie under the surface of the voxelised solid and still be on its outside:
// half a voxel of rounding each for the surface and the point, half a voxel of margin.
constexpr double kOuterVoxels = 1.5;

double FaceArea(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& face) {
  const Eigen::Vector3d a = mesh.vertices[face[0]].cast<double>();
  const Eigen::Vector3d b = mesh.vertices[face[1]].cast<double>();
  const Eigen::Vector3d c = mesh.vertices[face[2]].cast<double>();
  return 0.5 * (b - a).cross(c - a).norm();
}

Box3 UsedBox(const TriangleMesh& mesh) {
  Box3 box;
  for (const auto& face : mesh.faces) {
    for (const std::uint32_t n : face) box.Extend(mesh.vertices[n].cast<double>());
  }
  return box;
}

// Share within the threshold and capped mean.
std::pair<double, double> Summarise(const std::vector<double>& distances, double threshold_m) {
  if (distances.empty()) return {0, 0};
  double sum = 0;
  std::int64_t near = 0;
  for (const double d : distances) {
    sum += std::min(d, kCapThresholds * threshold_m);
    near += d <= threshold_m ? 1 : 0;
  }
  const auto count = static_cast<double>(distances.size());
  return {static_cast<double>(near) / count, sum / count};
}

}  // namespace

Status CheckTriangles(const TriangleMesh& mesh, std::string_view name) {
  const std::string where(name);
  if (mesh.empty()) return InvalidInput(where + ": the mesh has no faces");
  double area = 0;
  for (const auto& face : mesh.faces) {
    for (const std::uint32_t n : face) {
      if (n >= mesh.vertices.size())
        return InvalidInput(where + ": a face names vertex " + std::to_string(n) + " of " +
                            std::to_string(mesh.vertices.size()));
      if (!mesh.vertices[n].allFinite())
        return InvalidInput(where + ": vertex " + std::to_string(n) + " is not finite");
    }
    area += FaceArea(mesh, face);
  }
  if (!(area > 0) || !std::isfinite(area))
    return InvalidInput(where + ": the mesh has no area, or one that is not finite");
  return Ok();
}

std::vector<Eigen::Vector3d> SampleSurface(const TriangleMesh& mesh,
                                           const Pose3& b_from_mesh,
                                           double area_m2,
                                           std::uint64_t seed) {
  double total = 0;
  for (const auto& face : mesh.faces) total += FaceArea(mesh, face);
  const double per_point = std::max(area_m2, total / kMaxSurfaceSamples);
  std::vector<Eigen::Vector3d> points;
  if (!(per_point > 0)) return points;
  Random random(seed, "surface", 0);
  // Stratified along the faces' running area: every stretch of `per_point` gets one point.
  double due = per_point * random.Uniform();
  for (const auto& face : mesh.faces) {
    due -= FaceArea(mesh, face);
    while (due < 0) {
      const double root = std::sqrt(random.Uniform());
      const double second = random.Uniform();
      const auto corner = [&](std::size_t n) { return mesh.vertices[face[n]].cast<double>(); };
      points.push_back(b_from_mesh *
                       Eigen::Vector3d((1 - root) * corner(0) + root * (1 - second) * corner(1) +
                                       root * second * corner(2)));
      due += per_point;
    }
  }
  return points;
}

std::vector<Eigen::Vector3d> OuterPoints(const TriangleMesh& mesh,
                                         std::span<const Eigen::Vector3d> points_mesh) {
  std::vector<Eigen::Vector3d> outer(points_mesh.begin(), points_mesh.end());
  const Result<VoxelGrid> grid = shape::Voxelize(mesh);
  if (!grid.ok()) return outer;
  const shape::ShapeModel model(*grid);
  const Box3 box = UsedBox(mesh);
  const double scale = kModelExtent / box.Size().maxCoeff();
  const Eigen::Vector3d centre = box.Center();
  std::erase_if(outer, [&](const Eigen::Vector3d& p) {
    const Eigen::Vector3f p_object = (scale * (p - centre)).cast<float>();
    return model.Distance(p_object) < static_cast<float>(-kOuterVoxels * kVoxelSize);
  });
  return outer;
}

SurfaceComparison CompareSurfaces(std::span<const Eigen::Vector3d> estimated,
                                  std::span<const Eigen::Vector3d> truth,
                                  double threshold_m) {
  SurfaceComparison result;
  result.num_estimated = static_cast<std::int64_t>(estimated.size());
  result.num_true = static_cast<std::int64_t>(truth.size());
  std::tie(result.accuracy, result.accuracy_m) =
      Summarise(NearestDistances(estimated, truth), threshold_m);
  std::tie(result.completeness, result.completeness_m) =
      Summarise(NearestDistances(truth, estimated), threshold_m);
  const double sum = result.accuracy + result.completeness;
  result.f_score = sum > 0 ? 2 * result.accuracy * result.completeness / sum : 0;
  return result;
}

}  // namespace deepslam::eval
