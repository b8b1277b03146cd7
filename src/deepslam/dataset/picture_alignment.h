// Whether the edges of depth lie on edges of colour, and if not, what would fit: colour that is
// mirrored against depth, late by frames, or seen from beside it gives maps that are wrong without
// being invalid.
//
// Edges of depth are jumps between neighbours. How strongly colour changes there, over how strongly
// it does anywhere (ranks in the picture, so that no texture outweighs the rest), is measured as
// the pictures are, and as they would be mirrored, turned, moved, scaled, and of other moments.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "deepslam/core/image.h"

namespace deepslam::dataset {

// Frames around the one of a sample, by which colour may be late; 0 is its own.
inline constexpr std::array<int, 7> kPictureOffsets = {0, -1, 1, -2, 2, -4, 4};

// Depth and colour of a frame, of one size and some 320 px wide: finer ones show texture, not
// edges.
struct PictureSample {
  DepthImage depth_m;  // 0 invalid
  // Of the frames kPictureOffsets away; empty images where there is none.
  std::array<IntensityImage, kPictureOffsets.size()> pictures;
};

// In words, for the user; empty where nothing fits clearly better than the pictures as they are.
[[nodiscard]] std::vector<std::string> AlignmentDoubts(std::span<const PictureSample> samples);

}  // namespace deepslam::dataset
