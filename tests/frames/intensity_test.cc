#include "deepslam/frames/intensity.h"

#include <gtest/gtest.h>

#include "deepslam/core/random.h"

namespace deepslam {
namespace {

ColourImage RandomColours(int width, int height) {
  Random random(3);
  ColourImage colour(width, height);
  const auto byte = [&] { return static_cast<std::uint8_t>(random.Index(256)); };
  for (Rgb8& c : colour) c = {byte(), byte(), byte()};
  return colour;
}

TEST(IntensityOf, IsTheMeanLumaOfWholeBlocks) {
  const ColourImage colour = RandomColours(137, 83);
  for (const int factor : {1, 2, 3, 5, 32, 33, 80, 83}) {
    const IntensityImage intensity = IntensityOf(colour, factor);
    ASSERT_EQ(intensity.width(), 137 / factor);
    ASSERT_EQ(intensity.height(), 83 / factor);
    for (int v = 0; v < intensity.height(); ++v) {
      for (int u = 0; u < intensity.width(); ++u) {
        double sum = 0;
        for (int y = 0; y < factor; ++y) {
          for (int x = 0; x < factor; ++x) {
            const Rgb8& c = colour(u * factor + x, v * factor + y);
            sum += 0.299 * c.r + 0.587 * c.g + 0.114 * c.b;
          }
        }
        EXPECT_NEAR(static_cast<double>(intensity(u, v)), sum / (factor * factor), 1.0) << factor;
      }
    }
  }
}

TEST(IntensityOf, GreyStaysWhatItIs) {
  for (const int level : {0, 1, 128, 255}) {
    const auto byte = static_cast<std::uint8_t>(level);
    EXPECT_FLOAT_EQ(IntensityOf(ColourImage(8, 8, {byte, byte, byte}), 4)(1, 1),
                    static_cast<float>(level));
  }
  EXPECT_TRUE(IntensityOf(ColourImage(), 2).empty());
  EXPECT_TRUE(IntensityOf(ColourImage(3, 3), 4).empty());
}

TEST(ReducedIntensity, BlocksOfBlocksAreBlocks) {
  const ColourImage colour = RandomColours(48, 36);
  const IntensityImage at_once = IntensityOf(colour, 6);
  const IntensityImage in_two = ReducedIntensity(IntensityOf(colour, 2), 3);
  ASSERT_EQ(in_two.width(), at_once.width());
  ASSERT_EQ(in_two.height(), at_once.height());
  for (std::size_t k = 0; k < at_once.size(); ++k)
    EXPECT_NEAR(in_two.data()[k], at_once.data()[k], 1e-3F);
}

}  // namespace
}  // namespace deepslam
