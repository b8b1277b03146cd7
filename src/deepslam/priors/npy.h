// Arrays as NumPy reads them: the header of a .npy file (format version 1.0), before the values in
// row-major order, little-endian.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace deepslam::priors {

// `dtype` as NumPy names it: "|u1", "<i4", "<f4".
[[nodiscard]] std::string NpyHeader(std::string_view dtype, std::span<const std::size_t> shape);

}  // namespace deepslam::priors
