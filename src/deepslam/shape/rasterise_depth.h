// Depth images of triangle meshes.
#pragma once

#include "deepslam/core/image.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::shape {

// Depth of a mesh's nearest surface at pixel centres, by z-buffer; 0 where it is not. Both sides of
// faces are seen; faces that reach behind the camera are cut at its near plane (1 cm). Faces with
// corners that are not finite, or that are not there, are left out.
[[nodiscard]] DepthImage RasteriseDepth(const TriangleMesh& mesh,
                                        const Pose3& camera_from_mesh,
                                        const PinholeCamera& camera);

}  // namespace deepslam::shape
