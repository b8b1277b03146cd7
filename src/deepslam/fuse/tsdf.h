// The room's measured surface: frames fused into a truncated signed distance field (Curless and
// Levoy 1996).
#pragma once

#include <cstdint>
#include <memory>

#include "deepslam/core/image.h"
#include "deepslam/core/options.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::fuse {

struct FuseOptions {
  double voxel_m = 0.02;         // edge of a voxel
  double truncation_m = 0.06;    // the field is kept this far in front of and behind the surface
  double max_depth_m = 4.0;      // depth beyond is noise more than surface
  int max_faces = 400'000;       // a larger mesh is decimated to this
  int min_component_faces = 50;  // smaller pieces are noise and go
  int max_voxel_blocks =
      400'000;  // of 16^3 voxels; the room is too large for this voxel size beyond
};
void Describe(OptionsVisitor& visitor, FuseOptions& options);

// Frames are integrated in the order of the calls; equal calls give byte-equal meshes, whatever the
// thread count.
class TsdfFusion {
 public:
  explicit TsdfFusion(const FuseOptions& options);
  ~TsdfFusion();
  TsdfFusion(TsdfFusion&&) noexcept;
  TsdfFusion& operator=(TsdfFusion&&) noexcept;

  // Adds a frame. Pixels where `leave_out` (size of the image, or null) is not 0 are not fused. A
  // frame with no usable depth changes nothing. Errors: sizes that disagree, a camera or pose that
  // is not finite, a room that outgrows max_voxel_blocks (nothing of the frame is fused then).
  Status Integrate(const Frame& frame,
                   const PinholeCamera& camera,
                   const Pose3& world_from_camera,
                   const Mask* leave_out);

  // The surface in world metres, coloured, faces towards the cameras; vertices in lexicographic
  // order. Empty when nothing was fused. Open at the borders of what was seen.
  [[nodiscard]] TriangleMesh ExtractMesh() const;

  // The same as the last call: the field makes room for what finishing a large mesh takes.
  [[nodiscard]] TriangleMesh TakeMesh() &&;

  // Points on the surface, one per crossing of a voxel edge: the size of a fused cloud of this
  // voxel size (15 bytes each as binary PLY with colour). Fuse at 1 cm for the baseline of the
  // map's size.
  [[nodiscard]] std::int64_t CountSurfacePoints() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// How many points a field of this voxel size would have on a surface: a plane with normal n crosses
// (|n_x| + |n_y| + |n_z|) / voxel^2 of a grid's edges per area. Within a few per cent of
// CountSurfacePoints, without fusing again. Indices must be in range.
[[nodiscard]] std::int64_t ExpectedSurfacePoints(const TriangleMesh& surface, double voxel_m);

}  // namespace deepslam::fuse
