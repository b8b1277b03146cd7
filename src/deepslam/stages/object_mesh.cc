#include "deepslam/stages/object_mesh.h"

namespace deepslam::stages {

Result<TriangleMesh> MakeObjectMesh(const VoxelGrid& grid,
                                    double scale_m,
                                    const mesh::SurfaceOptions& surface,
                                    const mesh::RefineOptions& refine) {
  const Result<TriangleMesh> extracted = mesh::ExtractSurface(grid, surface);
  if (!extracted.ok()) return extracted.error();
  Result<TriangleMesh> refined = mesh::RefineMesh(*extracted, refine);
  if (!refined.ok()) return refined.error();
  for (Eigen::Vector3f& vertex : refined->vertices) vertex *= static_cast<float>(scale_m);
  return refined;
}

}  // namespace deepslam::stages
