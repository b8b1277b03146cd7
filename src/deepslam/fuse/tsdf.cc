#include "deepslam/fuse/tsdf.h"

#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "deepslam/fuse/block_surface.h"
#include "deepslam/fuse/canonical_mesh.h"
#include "deepslam/fuse/fewer_faces.h"
#include "deepslam/fuse/frame_check.h"
#include "deepslam/fuse/voxel_blocks.h"

namespace deepslam::fuse {
namespace {

// Colour is wanted, and a mask of the same size.
Status CheckInputs(const Frame& frame,
                   const PinholeCamera& camera,
                   const Pose3& pose,
                   const Mask* mask) {
  if (Status usable = CheckFrame(frame, camera, pose); !usable) return usable;
  const std::string name = "frame " + std::to_string(frame.idx.value);
  if (frame.colour.empty()) return InvalidInput(name + ": colour and depth differ in size");
  if (mask != nullptr &&
      (mask->width() != frame.depth_m.width() || mask->height() != frame.depth_m.height())) {
    return InvalidInput(name + ": the mask to leave out differs from the image in size");
  }
  return Ok();
}

// Depth that is to be fused.
DepthImage UsableDepth(const Frame& frame, const Mask* leave_out, double max_depth_m) {
  DepthImage usable = frame.depth_m;
  for (int v = 0; v < usable.height(); ++v) {
    for (int u = 0; u < usable.width(); ++u) {
      float& depth = usable(u, v);
      const bool kept = depth > 0 && static_cast<double>(depth) <= max_depth_m &&
                        (leave_out == nullptr || (*leave_out)(u, v) == 0);
      if (!kept) depth = 0;
    }
  }
  return usable;
}

// Without noise, no larger than wanted, in an order of its own.
TriangleMesh Finished(TriangleMesh surface, const FuseOptions& options) {
  TriangleMesh mesh =
      CanonicalMesh(WithoutSmallComponents(std::move(surface), options.min_component_faces));
  const auto max_faces = static_cast<std::size_t>(options.max_faces);
  return mesh.faces.size() <= max_faces ? mesh
                                        : CanonicalMesh(WithFewerFaces(std::move(mesh), max_faces));
}

}  // namespace

struct TsdfFusion::Impl {
  explicit Impl(const FuseOptions& o) : options(o), blocks(o.voxel_m, o.truncation_m) {}

  FuseOptions options;
  VoxelBlocks blocks;
};

TsdfFusion::TsdfFusion(const FuseOptions& options) : impl_(std::make_unique<Impl>(options)) {}
TsdfFusion::~TsdfFusion() = default;
TsdfFusion::TsdfFusion(TsdfFusion&&) noexcept = default;
TsdfFusion& TsdfFusion::operator=(TsdfFusion&&) noexcept = default;

Status TsdfFusion::Integrate(const Frame& frame,
                             const PinholeCamera& camera,
                             const Pose3& world_from_camera,
                             const Mask* leave_out) {
  const Status usable = CheckInputs(frame, camera, world_from_camera, leave_out);
  if (!usable) return usable;
  const bool added =
      impl_->blocks.Integrate(UsableDepth(frame, leave_out, impl_->options.max_depth_m),
                              frame.colour,
                              camera,
                              world_from_camera,
                              static_cast<std::size_t>(impl_->options.max_voxel_blocks));
  if (!added) {
    return InvalidInput("frame " + std::to_string(frame.idx.value) +
                        ": the room outgrows fuse.max_voxel_blocks = " +
                        std::to_string(impl_->options.max_voxel_blocks) +
                        "; raise it, or fuse.voxel_m");
  }
  return Ok();
}

TriangleMesh TsdfFusion::ExtractMesh() const {
  return Finished(SurfaceOf(impl_->blocks), impl_->options);
}

TriangleMesh TsdfFusion::TakeMesh() && {
  TriangleMesh surface = SurfaceOf(impl_->blocks);
  const FuseOptions options = impl_->options;
  impl_.reset();
  return Finished(std::move(surface), options);
}

std::int64_t TsdfFusion::CountSurfacePoints() const {
  return static_cast<std::int64_t>(SurfaceOf(impl_->blocks).vertices.size());
}

std::int64_t ExpectedSurfacePoints(const TriangleMesh& surface, double voxel_m) {
  double crossings_m2 = 0;
  for (const auto& face : surface.faces) {
    const Eigen::Vector3d a = surface.vertices[face[0]].cast<double>();
    const Eigen::Vector3d b = surface.vertices[face[1]].cast<double>();
    const Eigen::Vector3d c = surface.vertices[face[2]].cast<double>();
    crossings_m2 += 0.5 * (b - a).cross(c - a).cwiseAbs().sum();
  }
  return std::llround(crossings_m2 / (voxel_m * voxel_m));
}

void Describe(OptionsVisitor& visitor, FuseOptions& options) {
  visitor.Field("voxel_m", options.voxel_m, {0.002, 0.2}, "m", "edge of a voxel of the fused room");
  visitor.Field("truncation_m",
                options.truncation_m,
                {0.004, 1},
                "m",
                "the distance field is kept this far from the surface; 2-3 voxels");
  visitor.Field("max_depth_m", options.max_depth_m, {0.1, 50}, "m", "depth beyond is not fused");
  visitor.Field("max_faces",
                options.max_faces,
                {100, 50'000'000},
                "1",
                "a larger room mesh is decimated to this number of faces");
  visitor.Field("max_voxel_blocks",
                options.max_voxel_blocks,
                {1, 10'000'000},
                "1",
                "most blocks of 16^3 voxels (48 KB each) before fusion stops");
}

}  // namespace deepslam::fuse
