// The voxels that map.json embeds.
#include "deepslam/shape/voxel_code.h"
#include "deepslam/core/base64.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(voxel_code) {
  const Result<VoxelGrid> grid = shape::DecodeVoxels(bytes);
  if (!grid.ok()) return false;
  const Result<VoxelGrid> again = shape::DecodeVoxels(shape::EncodeVoxels(*grid));
  DEEPSLAM_CHECK(again.ok() && again->occupied == grid->occupied, "coding loses nothing");
  return true;
}
