#include "deepslam/dataset/depth_registration.h"

#include <gmock/gmock.h>

#include "deepslam/core/random.h"
#include "support/box_world.h"

namespace deepslam::dataset {
namespace {

using testing_support::Cuboid;
using testing_support::LookAt;
using testing_support::RenderBoxes;

// A room with a table and a thin post in front of it, every depth known exactly.
std::vector<Cuboid> World() {
  std::vector<Cuboid> world = testing_support::TableAt(0, 0, 0);
  world.push_back({1, {-0.3, -1.2, 0}, {-0.25, -1.15, 1.5}});
  world.push_back({-1, {-4, 2.0, 0}, {4, 2.1, 3}});
  return world;
}

const Pose3 kWorldFromDepth = LookAt({0.4, -2.6, 1.5}, {0, 0, 0.5});

DepthImage Render(const PinholeCamera& camera, const Pose3& world_from_camera) {
  return RenderBoxes(World(), camera, world_from_camera).frame.depth_m;
}

// The depths within two pixels of a place, lowest and highest; {0, 0} when one is missing.
std::pair<float, float> RangeAround(const DepthImage& depth_m, int u, int v) {
  float low = 1e9f;
  float high = 0;
  for (int y = v - 2; y <= v + 2; ++y) {
    for (int x = u - 2; x <= u + 2; ++x) {
      if (!depth_m.Contains(x, y) || depth_m(x, y) <= 0) return {0.0f, 0.0f};
      low = std::min(low, depth_m(x, y));
      high = std::max(high, depth_m(x, y));
    }
  }
  return {low, high};
}

struct Comparison {
  int num_smooth = 0;    // pixels of the truth away from edges
  int num_missing = 0;   // of those, not covered
  int num_wrong = 0;     // of those, off by more than the tolerance
  int num_phantoms = 0;  // pixels anywhere whose depth is no depth of their surroundings
};

Comparison Compare(const DepthImage& registered, const DepthImage& truth, float tolerance) {
  Comparison result;
  for (int v = 2; v < truth.height() - 2; ++v) {
    for (int u = 2; u < truth.width() - 2; ++u) {
      const auto [low, high] = RangeAround(truth, u, v);
      if (low <= 0) continue;
      const float d = registered(u, v);
      if (d > 0 && (d < low * (1 - tolerance) || d > high * (1 + tolerance))) ++result.num_phantoms;
      // Beyond that the table's edge or the post lies between.
      if (high > 1.05f * low) {
        // Neither of the two surfaces is a depth in the middle between them.
        const float middle = 0.5f * (low + high);
        if (high > 1.3f * low && d > 0 && std::abs(d - middle) < 0.1f * (high - low))
          ++result.num_phantoms;
        continue;
      }
      ++result.num_smooth;
      if (d <= 0) {
        ++result.num_missing;
      } else if (std::abs(d - truth(u, v)) > tolerance * truth(u, v)) {
        ++result.num_wrong;
      }
    }
  }
  return result;
}

TEST(RegisterDepth, OfOneCameraIsTheSameImage) {
  const PinholeCamera camera{80, 60, 65, 65, 39.5, 29.5};
  const DepthImage depth_m = Render(camera, kWorldFromDepth);
  EXPECT_EQ(RegisterDepth(depth_m, camera, Pose3(), camera), depth_m);
}

TEST(RegisterDepth, FinerImageOfTheSameViewHasTheTrueDepth) {
  const PinholeCamera coarse{128, 96, 104, 104, 63.5, 47.5};
  // 2.5 times as fine: pixel centres do not coincide.
  const PinholeCamera fine{320, 240, 260, 260, 159.5, 119.5};
  const DepthImage truth = Render(fine, kWorldFromDepth);
  const DepthImage registered =
      RegisterDepth(Render(coarse, kWorldFromDepth), coarse, Pose3(), fine);
  const Comparison found = Compare(registered, truth, 0.001f);
  EXPECT_GT(found.num_smooth, 40000);
  EXPECT_EQ(found.num_missing, 0);
  // Where an edge lies within a coarse pixel of a smooth place.
  EXPECT_LT(found.num_wrong, found.num_smooth / 50);
  EXPECT_LT(found.num_phantoms, found.num_smooth / 50);
}

TEST(RegisterDepth, FromBesideHasTheTrueDepthOfTheOtherCamera) {
  const PinholeCamera depth_camera{320, 240, 293, 293, 160, 120};
  const PinholeCamera colour_camera{320, 240, 262, 263, 158, 121};
  const Pose3 colour_from_depth{RotationFromVector({0.01, -0.008, 0.004}), {-0.05, 0.002, 0.001}};
  const DepthImage truth = Render(colour_camera, kWorldFromDepth * colour_from_depth.Inverse());
  const DepthImage registered = RegisterDepth(
      Render(depth_camera, kWorldFromDepth), depth_camera, colour_from_depth, colour_camera);
  const Comparison found = Compare(registered, truth, 0.001f);
  EXPECT_GT(found.num_smooth, 40000);
  // The colour camera's wider field of view, and what the post hides from the depth camera.
  EXPECT_LT(found.num_missing, found.num_smooth / 4);
  EXPECT_LT(found.num_wrong, found.num_smooth / 100);
  EXPECT_LT(found.num_phantoms, found.num_smooth / 50);
}

TEST(RegisterDepth, NearestSurfaceHidesWhatLiesBehind) {
  // A wall at 3 m; left half covered by a plate at 1 m. From 0.4 m to the left the plate covers
  // pixels that show the wall from the depth camera.
  const PinholeCamera camera{64, 48, 50, 50, 31.5, 23.5};
  DepthImage depth_m(64, 48, 3.0f);
  for (int v = 0; v < 48; ++v) {
    for (int u = 0; u < 32; ++u) depth_m(u, v) = 1.0f;
  }
  const Pose3 target_from_depth{Eigen::Quaterniond::Identity(), {0.4, 0, 0}};
  const DepthImage registered = RegisterDepth(depth_m, camera, target_from_depth, camera);
  // The plate's right edge moved by 0.4 * 50 / 1 = 20 px, the wall's pixels by 6.7.
  EXPECT_FLOAT_EQ(registered(45, 24), 1.0f);
  EXPECT_FLOAT_EQ(registered(50, 24), 1.0f);
  EXPECT_FLOAT_EQ(registered(55, 24), 3.0f);
  EXPECT_EQ(registered(5, 24), 0) << "the depth camera did not look there";
  for (const float d : registered)
    EXPECT_TRUE(d == 0 || d == 1.0f || std::abs(d - 3.0f) < 1e-5f) << d;
}

TEST(RegisterDepth, NothingComesOfNothing) {
  const PinholeCamera camera{16, 12, 13, 13, 7.5, 5.5};
  const PinholeCamera finer{32, 24, 26, 26, 15.5, 11.5};
  const DepthImage empty(16, 12);
  const Pose3 beside{Eigen::Quaterniond::Identity(), {0.1, 0, 0}};
  for (const Pose3& pose : {Pose3(), beside}) {
    for (const float d : RegisterDepth(empty, camera, pose, finer)) EXPECT_EQ(d, 0);
  }
  // A depth camera looking away from the colour camera.
  const Pose3 away{RotationFromVector({0, 3.1, 0}), {0, 0, 0}};
  for (const float d : RegisterDepth(DepthImage(16, 12, 2.0f), camera, away, finer))
    EXPECT_EQ(d, 0);
}

TEST(FrameCamera, KeepsAsMuchOfColourAsDepthAndDetectorsUse) {
  const PinholeCamera phone{1920, 1440, 1600, 1600, 959.5, 719.5};
  const PinholeCamera lidar{256, 192, 213, 213, 127.5, 95.5};
  EXPECT_EQ(FrameCamera({phone, lidar, Pose3(), 1000}), phone.Reduced(3));
  EXPECT_EQ(FrameCamera({phone, lidar, Pose3(), 1000}).width, 640);
  const PinholeCamera tablet{1296, 968, 1170, 1170, 647, 483};
  const PinholeCamera structure{640, 480, 577, 577, 319, 239};
  EXPECT_EQ(FrameCamera({tablet, structure, Pose3(), 1000}).width, 648);
  EXPECT_EQ(FrameCamera({structure, structure, Pose3(), 1000}), structure);
  EXPECT_EQ(FrameCamera({phone, phone, Pose3(), 1000}), phone) << "nothing is thrown away unasked";
}

TEST(ReduceColour, IsTheMeanOfBlocks) {
  ColourImage colour(5, 4);
  for (int v = 0; v < 4; ++v) {
    for (int u = 0; u < 5; ++u)
      colour(u, v) = {static_cast<std::uint8_t>(10 * u), static_cast<std::uint8_t>(20 * v), 7};
  }
  const ColourImage half = ReduceColour(colour, 2);
  ASSERT_EQ(half.width(), 2);
  ASSERT_EQ(half.height(), 2);
  EXPECT_EQ(half(0, 0), (Rgb8{5, 10, 7}));
  EXPECT_EQ(half(1, 1), (Rgb8{25, 50, 7}));
}

}  // namespace
}  // namespace deepslam::dataset
