#include "deepslam/frames/pixel_mask.h"

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

// Files of other programs may hold runs of no pixels.
TEST(PixelMask, IsTheSameWhateverItsRunsAreCutInto) {
  const auto mask = PixelMask::FromRle("231", 3, 2);
  ASSERT_TRUE(mask.ok()) << mask.error().message;
  // 2 zeros, a one, no zero, two ones, a zero, no one.
  const auto cut = PixelMask::FromRle("21011N", 3, 2);
  ASSERT_TRUE(cut.ok()) << cut.error().message;
  EXPECT_EQ(*cut, *mask);
  EXPECT_EQ(cut->Unpacked(), mask->Unpacked());
  EXPECT_EQ(*PixelMask::FromRle("006", 3, 2), PixelMask(Mask(3, 2))) << "no zeros, no ones, zeros";
  EXPECT_EQ(*PixelMask::FromRle("06", 3, 2), PixelMask(Mask(3, 2, 1)));
}

TEST(PixelMask, RefusesRunsThatDoNotFillTheImage) {
  EXPECT_FALSE(PixelMask::FromRle("6", 4, 2).ok());
  EXPECT_FALSE(PixelMask::FromRle("6", 1 << 20, 1 << 20).ok());
  EXPECT_FALSE(PixelMask::FromRle("", 3, 2).ok());
}

TEST(PixelMask, CostsWhatItsOutlineDoes) {
  Mask mask(640, 480);
  for (int v = 100; v < 300; ++v) {
    for (int u = 200; u < 400; ++u) mask(u, v) = 1;
  }
  EXPECT_LT(PixelMask(mask).rle().capacity(), 1024U);
}

TEST(PixelMask, IsEmptyWithoutAnImageAlone) {
  EXPECT_TRUE(PixelMask().empty());
  EXPECT_TRUE(PixelMask(Mask()).empty());
  EXPECT_FALSE(PixelMask(Mask(3, 2)).empty()) << "an image without pixels of the object is one";
}

}  // namespace
}  // namespace deepslam
