// Weights of the four texels round each point of a batch.
#pragma once

#include <cstddef>
#include <cstdint>

#include "deepslam/alignment/batch_columns.h"

namespace deepslam::alignment {

struct Bilinear {
  Column w00, w10, w01, w11;  // first the column's, then the row's texel
  IndexColumn upper_left;     // texels

  // Columns u and rows v of an image of this width, the last ones of it excluded.
  Bilinear(const Column& u, const Column& v, std::int32_t width, std::size_t size) {
#pragma GCC ivdep
    for (std::size_t k = 0; k < size; ++k) {
      const std::int32_t u0 = static_cast<std::int32_t>(u[k]);
      const std::int32_t v0 = static_cast<std::int32_t>(v[k]);
      const float a = u[k] - static_cast<float>(u0), b = v[k] - static_cast<float>(v0);
      w00[k] = (1 - a) * (1 - b);
      w10[k] = a * (1 - b);
      w01[k] = (1 - a) * b;
      w11[k] = a * b;
      upper_left[k] = v0 * width + u0;
    }
  }
};

}  // namespace deepslam::alignment
