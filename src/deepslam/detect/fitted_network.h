// A detector's network for pictures of one size. Exports are square, pictures are not: a quarter of
// what a network of 640 x 640 computes for 640 x 480 is padding.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "deepslam/detect/letterbox.h"

namespace deepslam::detect {

// The ONNX file with the sides of FitSides(picture, its own). Layers that convolve take any sides;
// what is noted of them goes along: targets of reshapes, and tables with a column for each cell,
// a cell of grids with strides 8, 16 and 32. Boxes stay pixels of the input.
//
// Nothing where the file's own sides fit already or are left open, and where it notes what is not
// known here. Whether what comes out can be run is for its loader to find out.
[[nodiscard]] std::optional<std::string> FittedNetwork(std::string_view onnx_bytes, Sides picture);

}  // namespace deepslam::detect
