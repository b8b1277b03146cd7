#include "deepslam/geometry/upright.h"

#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace deepslam {
namespace {

constexpr std::array kTurns = {
    QuarterTurn::kNone, QuarterTurn::kClockwise, QuarterTurn::kHalf, QuarterTurn::kAnticlockwise};

Image<int> Numbered(int width, int height) {
  Image<int> image(width, height);
  int n = 0;
  for (int& pixel : image) pixel = n++;
  return image;
}

TEST(TurnedImage, ClockwiseTheLeftColumnBecomesTheUpperRow) {
  const Image<int> image = Numbered(3, 2);  // 0 1 2 / 3 4 5
  const Image<int> turned = Turned(image, QuarterTurn::kClockwise);
  ASSERT_EQ(turned.width(), 2);
  ASSERT_EQ(turned.height(), 3);
  EXPECT_EQ(turned(0, 0), 3);
  EXPECT_EQ(turned(1, 0), 0);
  EXPECT_EQ(turned(1, 2), 2);
}

TEST(TurnedImage, TurnsAddUp) {
  const Image<int> image = Numbered(5, 4);
  const auto clockwise = [](const Image<int>& one) { return Turned(one, QuarterTurn::kClockwise); };
  EXPECT_EQ(clockwise(clockwise(image)), Turned(image, QuarterTurn::kHalf));
  EXPECT_EQ(clockwise(clockwise(clockwise(image))), Turned(image, QuarterTurn::kAnticlockwise));
  for (const QuarterTurn turn : kTurns)
    EXPECT_EQ(Turned(Turned(image, turn), Inverse(turn)), image);
  EXPECT_TRUE(Turned(Image<int>(), QuarterTurn::kClockwise).empty());
}

// The turned camera sees a point where the turned picture shows it.
TEST(TurnedCamera, SeesTheTurnedPicture) {
  const PinholeCamera camera{7, 5, 6.1, 5.9, 2.8, 2.3};
  const Image<int> image = Numbered(7, 5);
  for (const QuarterTurn turn : kTurns) {
    const PinholeCamera turned_camera = Turned(camera, turn);
    const Image<int> turned = Turned(image, turn);
    ASSERT_EQ(turned_camera.width, turned.width());
    ASSERT_EQ(turned_camera.height, turned.height());
    for (int v = 0; v < image.height(); ++v) {
      for (int u = 0; u < image.width(); ++u) {
        const Eigen::Vector3d point = Turned(camera.Unproject(u, v, 1.7), turn);
        const Eigen::Vector2d seen = *turned_camera.Project(point);
        EXPECT_EQ(turned(static_cast<int>(std::lround(seen.x())),
                         static_cast<int>(std::lround(seen.y()))),
                  image(u, v));
        const Box2 around = Turned(Box2{u - 0.4, v - 0.3, u + 0.4, v + 0.3}, 7, 5, turn);
        EXPECT_TRUE(around.Contains(seen.x(), seen.y()));
        EXPECT_NEAR(around.area_px(), 0.48, 1e-9);
      }
    }
    const Plane plane{Eigen::Vector3d(1, -2, 2) / 3.0, 0.4};
    const Eigen::Vector3d point(0.3, -1.2, 2);
    EXPECT_NEAR(Turned(plane, turn).SignedDistance(Turned(point, turn)),
                plane.SignedDistance(point),
                1e-12);
  }
}

TEST(UprightTurn, BringsWhatIsAboveToTheUpperEdge) {
  for (int deg = -180; deg < 180; ++deg) {
    if (std::abs(deg) % 90 == 45) continue;  // as good one way as the other
    const double angle = deg * std::numbers::pi / 180;
    const Eigen::Vector3d up(std::sin(angle), -std::cos(angle), -0.8);
    const Eigen::Vector3d turned = Turned(up, *UprightTurn(up));
    EXPECT_LT(turned.y(), -std::abs(turned.x())) << deg;
  }
}

TEST(UprightTurn, PicturesFromStraightAboveHaveNoUpperEdge) {
  EXPECT_FALSE(UprightTurn({0.15, 0.1, -1}).has_value());
  EXPECT_FALSE(UprightTurn({0, -0.2, 1}).has_value());
}

}  // namespace
}  // namespace deepslam
