// Designs as seen in a mirror: a corner sofa or a desk with drawers on one side is made for either
// hand, and a catalogue has one of the two.
#pragma once

#include <vector>

#include "deepslam/scene/model_library.h"

namespace deepslam::library {

// The model with left and right exchanged (y to -y), its id followed by "-mirrored".
[[nodiscard]] LibraryModel Mirrored(const LibraryModel& model);

// More than 3 % of the shape lies over a voxel and a half off its mirror image.
[[nodiscard]] bool HasAHand(const VoxelGrid& shape);

// Appends the mirror images of the models that have a hand, in their order.
void AddMirrored(std::vector<LibraryModel>& models);

}  // namespace deepslam::library
