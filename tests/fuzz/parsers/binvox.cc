// Voxel models.
#include "deepslam/shape/binvox.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(binvox) {
  const Result<VoxelGrid> grid = shape::ReadBinvox(bytes);
  if (!grid.ok()) return Refused(grid.error(), "binvox");
  const Result<VoxelGrid> again = shape::ReadBinvox(shape::WriteBinvox(*grid));
  DEEPSLAM_CHECK(again.ok() && again->occupied == grid->occupied, "writing loses nothing");
  return true;
}
