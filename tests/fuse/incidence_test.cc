#include "deepslam/fuse/incidence.h"

#include <cmath>

#include <gtest/gtest.h>

#include "deepslam/core/angles.h"
#include "deepslam/core/random.h"

namespace deepslam::fuse {
namespace {

const PinholeCamera kCamera{320, 240, 260, 260, 159.5, 119.5};

// The plane normal . p = distance_m before a camera, with a Kinect's noise.
DepthImage Plane(const Eigen::Vector3d& normal, double distance_m) {
  DepthImage depth_m(kCamera.width, kCamera.height, 0.0F);
  Random random(7, "noise", 0);
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 0; u < kCamera.width; ++u) {
      const double z = distance_m / normal.dot(kCamera.Ray(u, v));
      if (z > 0.4 && z < 5)
        depth_m(u, v) = static_cast<float>(z + 0.0015 * z * z * random.Normal());
    }
  }
  return depth_m;
}

TEST(IncidenceCosines, AreThoseOfAPlane) {
  for (const double tilt_deg : {0.0, 30.0, 60.0, 75.0}) {
    const double tilt = tilt_deg * kRadPerDeg;
    const Eigen::Vector3d normal(0, std::sin(tilt), std::cos(tilt));
    const DepthImage depth_m = Plane(normal, 2 * std::cos(tilt));
    const Image<float> cosines = IncidenceCosines(depth_m, kCamera);
    double sum = 0;
    double sum_true = 0;
    for (int u = 100; u < 220; ++u) {
      sum += static_cast<double>(cosines(u, 120));
      sum_true += normal.dot(kCamera.Ray(u, 120).normalized());
    }
    EXPECT_NEAR(sum, sum_true, 0.1 * sum_true) << tilt_deg;
  }
}

TEST(IncidenceCosines, AreOneAtEdgesAndWhereDepthIsMissing) {
  DepthImage depth_m = Plane(Eigen::Vector3d::UnitZ(), 3);
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 100; u < 104; ++u) depth_m(u, v) = 1.5F;  // a pole, 2 cm wide
    depth_m(200, v) = 0;
  }
  const Image<float> cosines = IncidenceCosines(depth_m, kCamera);
  for (const int u : {99, 100, 102, 104, 200}) EXPECT_EQ(cosines(u, 120), 1.0F) << u;
  EXPECT_EQ(cosines(0, 0), 1.0F);
}

TEST(IncidenceCosines, OfImagesTooSmallForNeighboursAreOne) {
  const PinholeCamera tiny{3, 2, 260, 260, 1, 0.5};
  const Image<float> cosines = IncidenceCosines(DepthImage(3, 2, 1.0F), tiny);
  for (const float cosine : cosines) EXPECT_EQ(cosine, 1.0F);
}

}  // namespace
}  // namespace deepslam::fuse
