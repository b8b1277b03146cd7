#include "deepslam/frames/local_contrast.h"

#include <cmath>

#include <gtest/gtest.h>

namespace deepslam {
namespace {

template <typename Grey>
Image<float> Painted(const Grey& grey) {
  Image<float> image(60, 40);
  for (int v = 0; v < image.height(); ++v) {
    for (int u = 0; u < image.width(); ++u) image(u, v) = static_cast<float>(grey(u, v));
  }
  return image;
}

double Grain(int u, int v) { return std::sin(2.1 * u + 0.3 * v) + std::sin(0.5 * u - 1.9 * v); }

TEST(NormaliseLocalContrast, IsTheSameUnderAnotherLight) {
  const Image<float> even =
      NormaliseLocalContrast(Painted([](int u, int v) { return 100 + 8 * Grain(u, v); }));
  const Image<float> shaded = NormaliseLocalContrast(
      Painted([](int u, int v) { return 60 + 0.5 * u + 0.3 * v + 16 * Grain(u, v); }));
  // Away from the border, where windows are not even.
  for (int v = 7; v < 33; ++v) {
    for (int u = 7; u < 53; ++u) EXPECT_NEAR(even(u, v), shaded(u, v), 0.05);
  }
}

TEST(NormaliseLocalContrast, OfNoContrastIsNothing) {
  for (const float value : NormaliseLocalContrast(Painted([](int, int) { return 77; })))
    EXPECT_NEAR(value, 0, 1e-3);
}

TEST(NormaliseLocalContrast, TakesImagesSmallerThanItsWindow) {
  EXPECT_TRUE(NormaliseLocalContrast(Image<float>()).empty());
  const Image<float> small = NormaliseLocalContrast(Image<float>(2, 1, 5.0F));
  EXPECT_EQ(small.width(), 2);
  EXPECT_NEAR(small(1, 0), 0, 1e-3);
}

}  // namespace
}  // namespace deepslam
