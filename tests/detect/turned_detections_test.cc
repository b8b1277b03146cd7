#include "deepslam/detect/turned_detections.h"

#include <gtest/gtest.h>

#include "deepslam/geometry/upright.h"

namespace deepslam::detect {
namespace {

constexpr Rgb8 kLamp{250, 200, 10};
constexpr Rgb8 kFoot{10, 20, 30};

// Knows lamps that stand: a light pixel, and dark ones right below it.
class StandingLamps final : public Detector {
 public:
  [[nodiscard]] Result<std::vector<RawDetection>> Detect(const ColourImage& image) const override {
    std::vector<RawDetection> found;
    for (int v = 0; v + 2 < image.height(); ++v) {
      for (int u = 0; u < image.width(); ++u) {
        if (!(image(u, v) == kLamp && image(u, v + 1) == kFoot && image(u, v + 2) == kFoot))
          continue;
        RawDetection lamp{"lamp", 0.9, {u - 0.5, v - 0.5, u + 0.5, v + 2.5}, {}};
        lamp.mask = Mask(image.width(), image.height());
        for (int k = 0; k < 3; ++k) lamp.mask(u, v + k) = 1;
        found.push_back(std::move(lamp));
      }
    }
    return found;
  }
};

ColourImage WithLamp() {
  ColourImage image(9, 6);
  image(5, 1) = kLamp;
  image(5, 2) = image(5, 3) = kFoot;
  return image;
}

TEST(DetectTurned, FindsWhatLiesOnItsSideAndSaysWhereItLies) {
  for (const QuarterTurn held : {QuarterTurn::kNone,
                                 QuarterTurn::kClockwise,
                                 QuarterTurn::kHalf,
                                 QuarterTurn::kAnticlockwise}) {
    const ColourImage lying = Turned(WithLamp(), held);
    const auto found = DetectTurned(StandingLamps(), lying, Inverse(held));
    ASSERT_TRUE(found.ok());
    ASSERT_EQ(found->size(), 1U);
    EXPECT_EQ((*found)[0].box_px, Turned(Box2{4.5, 0.5, 5.5, 3.5}, 9, 6, held));
    const Mask& mask = (*found)[0].mask;
    ASSERT_EQ(mask.width(), lying.width());
    for (int v = 0; v < lying.height(); ++v) {
      for (int u = 0; u < lying.width(); ++u)
        EXPECT_EQ(mask(u, v) != 0, !(lying(u, v) == Rgb8{})) << u << " " << v;
    }
  }
}

}  // namespace
}  // namespace deepslam::detect
