#include "deepslam/mesh/object_mesh.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>

#include "deepslam/core/parallel_in_order.h"

namespace deepslam::mesh {
namespace {

// Faces between what is occupied and what is not, which most of a mesh's time goes with.
std::size_t NumBoundaryFaces(const VoxelGrid& grid) {
  constexpr std::array<std::size_t, 3> kSteps = {
      1, std::size_t{kGridSize}, std::size_t{kGridSize} * kGridSize};
  const std::vector<std::uint8_t>& occupied = grid.occupied;
  std::size_t count = 0;
  for (const std::size_t step : kSteps) {
    for (std::size_t n = step; n < occupied.size(); ++n)
      count += occupied[n] != occupied[n - step] ? 1 : 0;
  }
  return count;
}

// Indices of the objects, that of the largest surface first: nothing large is left for the end.
std::vector<std::size_t> LargestFirst(std::span<const VoxelGrid> grids) {
  std::vector<std::size_t> num_faces;
  for (const VoxelGrid& grid : grids) num_faces.push_back(NumBoundaryFaces(grid));
  std::vector<std::size_t> order(grids.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater(), [&](std::size_t n) { return num_faces[n]; });
  return order;
}

}  // namespace

Result<TriangleMesh> MakeObjectMesh(const VoxelGrid& grid,
                                    double scale_m,
                                    const ObjectMeshOptions& options) {
  const Result<TriangleMesh> extracted = ExtractSurface(grid, options.surface);
  if (!extracted.ok()) return extracted.error();
  Result<TriangleMesh> refined = RefineMesh(*extracted, options.refine);
  if (!refined.ok()) return refined.error();
  for (Eigen::Vector3f& vertex : refined->vertices) vertex *= static_cast<float>(scale_m);
  return refined;
}

std::vector<Result<TriangleMesh>> MakeObjectMeshes(std::span<const VoxelGrid> grids,
                                                   std::span<const double> scales_m,
                                                   const ObjectMeshOptions& options,
                                                   const std::function<bool()>& stop_requested) {
  std::vector<Result<TriangleMesh>> meshes(grids.size(), Interrupted());
  const std::vector<std::size_t> order = LargestFirst(grids);
  ParallelInOrder(grids.size(), [&](std::size_t i) {
    const std::size_t n = order[i];
    if (!stop_requested()) meshes[n] = MakeObjectMesh(grids[n], scales_m[n], options);
  });
  return meshes;
}

}  // namespace deepslam::mesh
