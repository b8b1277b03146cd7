// Furniture hangs together: parts of a solid that came apart are tied to its largest one again.
#pragma once

#include <cstdint>
#include <span>

#include "deepslam/scene/voxel_grid.h"

namespace deepslam::refine {

// What a link costs for each voxel that is not occupied; 0: none goes there.
using LinkCosts = std::span<const std::uint8_t>;  // index order of VoxelGrid

// The grid with the cheapest links from each part to its largest one, by way of other parts where
// that is cheaper; a part that no link of at most `most` reaches stays apart. A link is a chain of
// voxels that share faces, and what `model` has right around it.
[[nodiscard]] VoxelGrid WithLinks(const VoxelGrid& grid,
                                  const VoxelGrid& model,
                                  LinkCosts costs,
                                  int most);

}  // namespace deepslam::refine
