#include "deepslam/detect/sharpness.h"

namespace deepslam::detect {

double Sharpness(const IntensityImage& intensity) {
  const int width = intensity.width();
  const int height = intensity.height();
  if (width < 3 || height < 3) return 0;
  double sum = 0;
  for (int v = 1; v + 1 < height; ++v) {
    const float* const above = intensity.row(v - 1);
    const float* const row = intensity.row(v);
    const float* const below = intensity.row(v + 1);
    float of_row = 0;
    for (int u = 1; u + 1 < width; ++u) {
      const float laplacian = 4 * row[u] - row[u - 1] - row[u + 1] - above[u] - below[u];
      of_row += laplacian * laplacian;
    }
    sum += of_row;
  }
  return sum / (static_cast<double>(width - 2) * (height - 2));
}

}  // namespace deepslam::detect
