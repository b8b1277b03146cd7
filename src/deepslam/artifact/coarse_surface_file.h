// The coarse surface of a capture as two files: `surface.ply`, a mesh as any program opens it
// (label: number of frames that saw the vertex), and `space.bin`, everything else of it.
//
// space.bin, little-endian: the line "deepslam space 1\n"; voxel_m (double); level_from_tracking as
// translation and rotation_xyzw (7 doubles); has_ground (byte); number of viewpoints (uint32) and
// their x, y, z (float); number of blocks (uint32); per block its index (3 int32), then what passed
// and what was blind, each as runs (value byte, length uint16) that together are a block long.
#pragma once

#include <string>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/scene/coarse_surface.h"

namespace deepslam::artifact {

// Fails on what is not finite.
[[nodiscard]] Result<std::string> EncodeSurfaceMesh(const CoarseSurface& surface,
                                                    std::string_view name);
[[nodiscard]] std::string EncodeSpace(const CoarseSurface& surface);

// Both files again; messages name the one that is at fault. Counts that the bytes cannot hold,
// other versions, and meshes without normals or labels are refused.
[[nodiscard]] Result<CoarseSurface> DecodeCoarseSurface(std::string_view mesh_bytes,
                                                        std::string_view mesh_name,
                                                        std::string_view space_bytes,
                                                        std::string_view space_name);

}  // namespace deepslam::artifact
