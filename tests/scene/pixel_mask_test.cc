#include "deepslam/scene/pixel_mask.h"

#include <gtest/gtest.h>

#include "deepslam/core/random.h"

namespace deepslam {
namespace {

// A mask of the size with each pixel of the window set by chance.
Mask Dotted(int width, int height, int u0, int v0, int u1, int v1, std::uint64_t seed) {
  Random random(seed, "mask", 0);
  Mask mask(width, height);
  for (int v = v0; v < v1; ++v) {
    for (int u = u0; u < u1; ++u) mask(u, v) = random.Uniform() < 0.5 ? 1 : 0;
  }
  return mask;
}

TEST(PixelMask, GivesTheVeryPixelsBack) {
  const std::vector<Mask> masks = {Dotted(64, 48, 0, 0, 64, 48, 1),
                                   Dotted(70, 33, 69, 32, 70, 33, 2),
                                   Dotted(37, 53, 5, 11, 30, 12, 3),
                                   Dotted(640, 480, 100, 200, 131, 333, 4),
                                   Mask(17, 9, 1),
                                   Mask(17, 9)};
  for (const Mask& mask : masks) {
    const PixelMask packed(mask);
    EXPECT_EQ(packed.width(), mask.width());
    EXPECT_EQ(packed.height(), mask.height());
    EXPECT_EQ(packed.Unpacked(), mask);
    EXPECT_EQ(packed, PixelMask(packed.Unpacked()));
    for (int v = 0; v < mask.height(); ++v) {
      for (int u = 0; u < mask.width(); ++u) ASSERT_EQ(packed(u, v), mask(u, v)) << u << ", " << v;
    }
  }
}

TEST(PixelMask, TellsDifferentMasksApart) {
  const Mask mask = Dotted(64, 48, 10, 10, 50, 40, 5);
  Mask other = mask;
  other(20, 20) ^= 1;
  EXPECT_NE(PixelMask(mask), PixelMask(other));
  Mask moved(64, 48);
  Mask shape(64, 48);
  moved(10, 10) = 1;
  shape(11, 10) = 1;
  EXPECT_NE(PixelMask(moved), PixelMask(shape));
}

TEST(PixelMask, IsEmptyWithoutAnImageAlone) {
  EXPECT_TRUE(PixelMask().empty());
  EXPECT_TRUE(PixelMask(Mask()).empty());
  EXPECT_FALSE(PixelMask(Mask(3, 2)).empty()) << "an image without pixels of the object is one";
}

}  // namespace
}  // namespace deepslam
