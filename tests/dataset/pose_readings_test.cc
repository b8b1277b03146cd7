// A walk past boxes, with its true poses written in all the ways in which people write them.
#include "deepslam/dataset/pose_readings.h"

#include <functional>

#include <gmock/gmock.h>

#include "deepslam/core/random.h"
#include "support/box_world.h"

namespace deepslam::dataset {
namespace {

using testing::HasSubstr;
using testing_support::Cuboid;
using testing_support::LookAt;

const PinholeCamera kCamera{96, 72, 80, 80, 47.5, 35.5};

std::vector<Cuboid> World() {
  std::vector<Cuboid> world = testing_support::TableAt(0, 0, 0);
  world.push_back({-1, {-3, 1.6, 0}, {3, 1.7, 2.6}});
  world.push_back({-1, {-1.8, -0.2, 0}, {-1.2, 0.5, 0.9}});
  world.push_back({-1, {1.1, 0.3, 0}, {1.5, 0.9, 1.3}});
  return world;
}

Pose3 OnTheWay(int i) {
  return LookAt({-1.2 + 0.12 * i, -2.4 + 0.03 * i, 1.3 + 0.02 * i},
                {-0.3 + 0.05 * i, 0.1, 0.5 + 0.03 * i});
}

PoseFit Fit(const std::function<Pose3(const Pose3&)>& written, double depth_noise_m = 0) {
  std::vector<DepthImage> depths_m;
  Random random(2);
  for (int i = 0; i < 12; ++i) {
    depths_m.push_back(RenderBoxes(World(), kCamera, OnTheWay(i)).frame.depth_m);
    for (float& d : depths_m.back())
      if (d > 0) d += static_cast<float>(depth_noise_m * random.Normal());
  }
  std::vector<PosedPair> pairs;
  for (const int gap : {1, 2, 4, 8}) {
    for (int a = 0; a + gap < 12; a += 3) {
      pairs.push_back({&depths_m[static_cast<std::size_t>(a)],
                       &depths_m[static_cast<std::size_t>(a + gap)],
                       written(OnTheWay(a)),
                       written(OnTheWay(a + gap))});
    }
  }
  return FitPoses(kCamera, pairs);
}

Pose3 Turned(const Pose3& pose, const Eigen::Quaterniond& turn) {
  return {(pose.rotation * turn).normalized(), pose.translation_m};
}

TEST(FitPoses, RightPosesAreRight) {
  for (const double noise_m : {0.0, 0.01}) {
    const PoseFit fit = Fit([](const Pose3& pose) { return pose; }, noise_m);
    EXPECT_GE(fit.num_pairs, 8);
    EXPECT_GT(fit.share, 0.8);
    EXPECT_FALSE(fit.contradicts()) << fit.best_reading;
  }
}

// The world's own axes are anybody's choice.
TEST(FitPoses, OtherWorldsAreAsRight) {
  const Pose3 other{RotationFromVector({1.1, -0.4, 2.0}), {30, -5, 2}};
  EXPECT_FALSE(Fit([&](const Pose3& pose) { return other * pose; }).contradicts());
}

struct Misread {
  std::string name;
  std::function<Pose3(const Pose3&)> written;
  std::string words;
};
void PrintTo(const Misread& misread, std::ostream* out) { *out << misread.name; }

class FitPosesOf : public testing::TestWithParam<Misread> {};

TEST_P(FitPosesOf, NamesTheReadingThatFits) {
  for (const double noise_m : {0.0, 0.01}) {
    const PoseFit fit = Fit(GetParam().written, noise_m);
    EXPECT_TRUE(fit.contradicts()) << fit.share << " " << fit.best_share;
    EXPECT_THAT(fit.best_reading, HasSubstr(GetParam().words));
  }
}

INSTANTIATE_TEST_SUITE_P(
    All,
    FitPosesOf,
    testing::Values(
        Misread{"OpenGl",
                [](const Pose3& p) { return Turned(p, Eigen::Quaterniond(0, 1, 0, 0)); },
                "y up, z back"},
        Misread{"WFirst",
                [](const Pose3& p) {
                  const Eigen::Quaterniond& q = p.rotation;
                  // qw qx qy qz where qx qy qz qw is read.
                  return Pose3{Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y()), p.translation_m};
                },
                "qw qx qy qz"},
        Misread{"WFirstOfOpenGl",
                [](const Pose3& p) {
                  const Eigen::Quaterniond open_gl(0, 1, 0, 0);
                  const Eigen::Quaterniond q = p.rotation * open_gl;
                  return Pose3{Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y()) * open_gl,
                               p.translation_m};
                },
                "qw qx qy qz"},
        Misread{"CameraFromWorld", [](const Pose3& p) { return p.Inverse(); }, "camera from world"},
        Misread{"Millimetres",
                [](const Pose3& p) {
                  return Pose3{p.rotation, 1000 * p.translation_m};
                },
                "millimetres"},
        Misread{"Centimetres",
                [](const Pose3& p) {
                  return Pose3{p.rotation, 100 * p.translation_m};
                },
                "centimetres"},
        Misread{"RosBody",
                [](const Pose3& p) { return Turned(p, Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5)); },
                "ROS's body"},
        Misread{"StructureFromMotion",
                [](const Pose3& p) {
                  return Pose3{p.rotation, 0.3 * p.translation_m};
                },
                "3.5 times as large"},
        Misread{"OpenGlCameraFromWorld",
                [](const Pose3& p) { return Turned(p, Eigen::Quaterniond(0, 1, 0, 0)).Inverse(); },
                "camera from world and camera axes y up"}),
    [](const auto& test) { return test.param.name; });

// Poses that no reading rights are not called misread.
TEST(FitPoses, PosesOfAnotherCaptureNameNoReading) {
  Random random(8);
  const PoseFit fit = Fit([&](const Pose3&) {
    return Pose3{RotationFromVector({random.Normal(), random.Normal(), random.Normal()}),
                 {random.Normal(), random.Normal(), random.Normal()}};
  });
  EXPECT_FALSE(fit.contradicts()) << fit.best_reading;
}

// Depth that lies mirrored fits best where the camera stands; that is no fault of the poses.
TEST(FitPoses, MirroredDepthNamesNoReading) {
  std::vector<DepthImage> depths_m;
  for (int i = 0; i < 12; ++i) {
    const DepthImage depth_m = RenderBoxes(World(), kCamera, OnTheWay(i)).frame.depth_m;
    DepthImage& mirrored = depths_m.emplace_back(kCamera.width, kCamera.height);
    for (int v = 0; v < kCamera.height; ++v) {
      for (int u = 0; u < kCamera.width; ++u) mirrored(u, v) = depth_m(kCamera.width - 1 - u, v);
    }
  }
  std::vector<PosedPair> pairs;
  for (const int gap : {1, 2}) {
    for (std::size_t a = 0; a + 2 < 12; a += 2) {
      const std::size_t b = a + static_cast<std::size_t>(gap);
      pairs.push_back({&depths_m[a],
                       &depths_m[b],
                       OnTheWay(static_cast<int>(a)),
                       OnTheWay(static_cast<int>(b))});
    }
  }
  const PoseFit fit = FitPoses(kCamera, pairs);
  EXPECT_FALSE(fit.contradicts()) << fit.share << " " << fit.best_share << " " << fit.best_reading;
}

TEST(FitPoses, NothingIsToldOfNothing) {
  EXPECT_FALSE(FitPoses(kCamera, {}).contradicts());
  const DepthImage empty(kCamera.width, kCamera.height);
  const std::vector<PosedPair> pairs(5, PosedPair{&empty, &empty, Pose3(), Pose3()});
  EXPECT_EQ(FitPoses(kCamera, pairs).num_pairs, 0);
}

}  // namespace
}  // namespace deepslam::dataset
