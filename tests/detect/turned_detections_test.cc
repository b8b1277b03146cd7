#include "deepslam/detect/turned_detections.h"

#include <array>

#include <gtest/gtest.h>

#include "deepslam/geometry/upright.h"
#include "support/box_world.h"

namespace deepslam::detect {
namespace {

constexpr std::array kTurns = {
    QuarterTurn::kNone, QuarterTurn::kClockwise, QuarterTurn::kHalf, QuarterTurn::kAnticlockwise};

constexpr Rgb8 kLamp{250, 200, 10};
constexpr Rgb8 kFoot{10, 20, 30};

// Knows lamps that stand: a light pixel, and dark ones right below it.
class StandingLamps final : public Detector {
 public:
  [[nodiscard]] std::vector<std::string> labels() const override { return {"lamp"}; }
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
  for (const QuarterTurn held : kTurns) {
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

// What a camera sees of cuboids on the floor.
struct View {
  Frame frame;
  PinholeCamera camera;
  Plane ground;
};

View Look(const std::vector<testing_support::Cuboid>& world,
          const Eigen::Vector3d& eye,
          const Eigen::Vector3d& target) {
  const PinholeCamera camera = testing_support::SmallCamera();
  const Pose3 world_from_camera = testing_support::LookAt(eye, target);
  return {testing_support::RenderBoxes(world, camera, world_from_camera).frame,
          camera,
          testing_support::FloorIn(world_from_camera)};
}

View Turned(const View& view, QuarterTurn held) {
  return {{view.frame.idx, 0, {}, Turned(view.frame.depth_m, held)},
          Turned(view.camera, held),
          Turned(view.ground, held)};
}

// The same of the picture turned.
Detection Turned(Detection detection, const View& view, QuarterTurn held) {
  detection.box_px =
      Turned(detection.box_px, view.frame.depth_m.width(), view.frame.depth_m.height(), held);
  if (!detection.mask.empty()) detection.mask = Turned(detection.mask.Unpacked(), held);
  return detection;
}

std::vector<Detection> Clusters(const View& view,
                                const std::vector<Detection>& covered,
                                QuarterTurn upright) {
  ClassTable classes;
  classes.classes.resize(1);
  classes.classes[0].name = "furniture";
  return UncoveredTurned(
      FindClustersTurned(view.frame, view.camera, view.ground, classes, {}, upright), covered);
}

void ExpectTheSameHoweverHeld(const View& view,
                              const std::vector<Detection>& covered,
                              std::size_t count) {
  const std::vector<Detection> standing = Clusters(view, covered, QuarterTurn::kNone);
  EXPECT_EQ(standing.size(), count);
  for (const QuarterTurn held : kTurns) {
    std::vector<Detection> covered_lying;
    for (const Detection& one : covered) covered_lying.push_back(Turned(one, view, held));
    const auto lying = Clusters(Turned(view, held), covered_lying, Inverse(held));
    ASSERT_EQ(lying.size(), count) << static_cast<int>(held);
    for (std::size_t n = 0; n < count; ++n) {
      const Detection expected = Turned(standing[n], view, held);
      EXPECT_EQ(lying[n].box_px, expected.box_px);
      EXPECT_EQ(lying[n].mask, expected.mask);
      EXPECT_EQ(lying[n].score, expected.score);
    }
  }
}

const testing_support::Cuboid kCabinet = {0, {-0.4, -0.25, 0}, {0.4, 0.25, 0.6}};

TEST(ClustersTurned, FindsTheSameHoweverThePictureIsHeld) {
  ExpectTheSameHoweverHeld(Look({kCabinet}, {0.8, -2.0, 1.3}, {0, 0, 0.3}), {}, 1);
  const testing_support::Cuboid stool = {1, {0.9, 0.3, 0}, {1.3, 0.7, 0.5}};
  ExpectTheSameHoweverHeld(Look({kCabinet, stool}, {0.8, -2.4, 1.4}, {0.4, 0, 0.3}), {}, 2);
}

TEST(ClustersTurned, LeavesToOthersWhatTheyHaveFound) {
  const View view = Look({kCabinet}, {0.8, -2.0, 1.3}, {0, 0, 0.3});
  std::vector<Detection> covered = Clusters(view, {}, QuarterTurn::kNone);
  ASSERT_EQ(covered.size(), 1U);
  ExpectTheSameHoweverHeld(view, covered, 0);
}

// In rows that run from the floor to the ceiling it seems to end where it does.
TEST(ClustersTurned, DoesNotTakeWhatRunsOutOfThePicture) {
  const testing_support::Cuboid counter = {0, {0.1, -0.3, 0}, {2.0, 0.3, 0.6}};
  for (const double side : {1.0, -1.0}) {
    testing_support::Cuboid to_the_side = counter;
    if (side < 0) {
      to_the_side.min_m.x() = -counter.max_m.x();
      to_the_side.max_m.x() = -counter.min_m.x();
    }
    ExpectTheSameHoweverHeld(Look({to_the_side}, {0, -2.0, 1.3}, {0, 0, 0.3}), {}, 0);
  }
}

}  // namespace
}  // namespace deepslam::detect
