#include "deepslam/synth/sensor_faults.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>

#include "deepslam/core/parallel.h"

namespace deepslam::synth {
namespace {

const PinholeCamera kCamera{320, 240, 262.5, 262.5, 159.5, 119.5};

SceneDescription Scene(const std::string& preset = "kinect_v1") {
  SceneDescription scene;
  scene.sensor = *DepthSensorPreset(preset);
  scene.faults = SensorFaults::None();
  return scene;
}

// A wall across the view; `step_m` nearer right of column `edge`.
SensedView Wall(double depth_m, double step_m = 0, int edge = 1 << 20) {
  render::RenderedView view{DepthImage(kCamera.width, kCamera.height),
                            Image<render::RayHit>(kCamera.width, kCamera.height)};
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 0; u < kCamera.width; ++u) {
      view.depth_m(u, v) = static_cast<float>(u < edge ? depth_m : depth_m - step_m);
      view.hits(u, v).instance = 0;
      view.hits(u, v).normal_world = -Eigen::Vector3f::UnitZ();
    }
  }
  return {view, {}, {}, {}};
}

// Every pixel's face turned by theta from its own ray.
SensedView TurnedWall(double depth_m, double theta_rad) {
  SensedView wall = Wall(depth_m);
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 0; u < kCamera.width; ++u) {
      const Eigen::Vector3d ray = kCamera.Ray(u, v).normalized();
      const Eigen::Vector3d axis = ray.cross(Eigen::Vector3d::UnitX()).normalized();
      wall.view.hits(u, v).normal_world = -(Eigen::AngleAxisd(theta_rad, axis) * ray).cast<float>();
    }
  }
  return wall;
}

DepthImage Sense(const SensedView& view, const SceneDescription& scene) {
  return ApplyDepthFaults(view, kCamera, Pose3(), scene, {1, 1});
}

struct Spread {
  double mean_m = 0;
  double deviation_m = 0;
};

Spread SpreadOf(const DepthImage& depth_m, double around_m) {
  double sum = 0, squares = 0, count = 0;
  for (const float d : depth_m) {
    const double off = static_cast<double>(d) - around_m;
    sum += off;
    squares += off * off;
    ++count;
  }
  return {sum / count, std::sqrt(squares / count - sum / count * sum / count)};
}

// The published formulas once more, written out per sensor.
double Published(const std::string& preset, double z, double theta) {
  const double ratio = theta / (std::numbers::pi / 2 - theta);
  if (preset == "kinect_v1") {
    return 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4) + 0.0001 / std::sqrt(z) * ratio * ratio;
  }
  if (preset == "kinect_v2") {
    return 1e-3 * (1.5 - 0.5 * z + 0.3 * z * z + 0.1 * z * std::sqrt(z) * ratio * ratio);
  }
  if (preset == "d435") return z * z * 0.08 / (385 * 0.05);
  return 0.005 + 0.002 * z;
}

TEST(DepthFaults, NoiseOfEverySensorHasThePublishedSizeAndNoBias) {
  for (const std::string& preset : DepthSensorPresetNames()) {
    SceneDescription scene = Scene(preset);
    scene.faults.axial_noise = true;
    for (const double depth_m : {1.0, 2.0, 3.5}) {
      for (const double theta_deg : {0.0, 30.0, 60.0}) {
        const double theta = theta_deg * std::numbers::pi / 180;
        const Spread spread = SpreadOf(Sense(TurnedWall(depth_m, theta), scene), depth_m);
        const double expected = Published(preset, depth_m, theta);
        // 76800 samples, of which neighbours share much: some 1200 of their own. The deviation is
        // known to 2 %, the mean to 3 % of it.
        EXPECT_NEAR(spread.deviation_m, expected, 0.04 * expected)
            << preset << " " << depth_m << " m, " << theta_deg << " deg";
        EXPECT_LT(std::abs(spread.mean_m), 0.1 * expected) << preset << " " << depth_m << " m";
      }
    }
  }
}

// Correlation of the noise with that of the pixel du, dv away.
double CorrelationAt(const DepthImage& depth_m, double around_m, int du, int dv) {
  double product = 0, square = 0;
  for (int v = 0; v + dv < depth_m.height(); ++v) {
    for (int u = 0; u + du < depth_m.width(); ++u) {
      const double a = static_cast<double>(depth_m(u, v)) - around_m;
      const double b = static_cast<double>(depth_m(u + du, v + dv)) - around_m;
      product += a * b;
      square += 0.5 * (a * a + b * b);
    }
  }
  return product / square;
}

TEST(DepthFaults, NeighboursShareNoiseAsFarAsTheMatchingWindowReaches) {
  SceneDescription scene = Scene();
  scene.faults.axial_noise = true;
  const DepthImage window = Sense(Wall(2), scene);
  for (const int distance : {1, 2, 4, 8}) {
    const double expected = std::exp(-distance / scene.sensor.noise_reach_px);
    EXPECT_NEAR(CorrelationAt(window, 2, distance, 0), expected, 0.05) << distance;
    EXPECT_NEAR(CorrelationAt(window, 2, 0, distance), expected, 0.05) << distance;
  }
  scene = Scene("kinect_v2");
  scene.faults.axial_noise = true;
  EXPECT_NEAR(CorrelationAt(Sense(Wall(2), scene), 2, 1, 0), 0, 0.02) << "each pixel its own";
}

TEST(DepthFaults, NoiseScaleMultipliesTheNoise) {
  SceneDescription scene = Scene();
  scene.faults.axial_noise = true;
  const double once = SpreadOf(Sense(Wall(2), scene), 2).deviation_m;
  scene.faults.noise_scale = 4;
  EXPECT_NEAR(SpreadOf(Sense(Wall(2), scene), 2).deviation_m, 4 * once, 0.01 * once);
}

TEST(DepthFaults, DepthComesInStepsOfDisparity) {
  SceneDescription scene = Scene();
  scene.faults.axial_noise = scene.faults.quantisation = true;
  // Khoshelham, Elberink 2012: about 7 cm at 5 m.
  const DepthSensor& kinect = scene.sensor;
  EXPECT_NEAR(QuantisedDepth(kinect, 5.03) - QuantisedDepth(kinect, 4.97), 0.07, 0.01);
  for (const float d : Sense(Wall(2.3), scene)) {
    const double steps = 580 * 0.075 / static_cast<double>(d) / 0.125;
    ASSERT_NEAR(steps, std::round(steps), 1e-4);
  }
}

TEST(DepthFaults, SwitchedOffTheyChangeNothing) {
  const SensedView wall = Wall(2.0, 0.8, 160);
  for (const std::string& preset : DepthSensorPresetNames())
    EXPECT_EQ(Sense(wall, Scene(preset)), wall.view.depth_m) << preset;
}

TEST(DepthFaults, ShadowsAreAsWideAsTheDistanceOfTheEyesSays) {
  SceneDescription scene = Scene();
  scene.faults.shadows = true;
  const double far_m = 3.0, near_m = 1.5;
  const int edge = 160;
  const auto holes = [&](const SensedView& view, int from, int to) {
    const DepthImage seen = Sense(view, scene);
    int count = 0;
    for (int u = from; u < to; ++u) count += seen(u, 100) == 0 ? 1 : 0;
    return count;
  };
  // Far left of near, and near left of far.
  const SensedView near_right = Wall(far_m, far_m - near_m, edge);
  const SensedView near_left = Wall(near_m, near_m - far_m, edge);
  const auto width_px = [&](double eye_m) {
    return kCamera.fx * eye_m * (1 / near_m - 1 / far_m);
  };
  EXPECT_NEAR(holes(near_right, 0, edge), width_px(scene.sensor.right_eye_m), 1.6);
  EXPECT_NEAR(holes(near_left, edge, kCamera.width), width_px(scene.sensor.left_eye_m), 1.6);
  EXPECT_EQ(holes(near_right, edge, kCamera.width) + holes(near_left, 0, edge), 0)
      << "near surfaces are in no shadow";
  EXPECT_DOUBLE_EQ(scene.sensor.left_eye_m + scene.sensor.right_eye_m, scene.sensor.baseline_m)
      << "projector and infrared camera stand on either side";
  scene.sensor = *DepthSensorPreset("kinect_v2");
  EXPECT_EQ(holes(near_right, 0, kCamera.width) + holes(near_left, 0, kCamera.width), 0)
      << "time of flight has no second eye";
}

int NumHoles(const DepthImage& depth_m) {
  return static_cast<int>(std::count(depth_m.begin(), depth_m.end(), 0.0f));
}

TEST(DepthFaults, GrazingFacesFarOnesDarkOnesAndShinyOnesAreHoles) {
  const int all = kCamera.width * kCamera.height;
  SceneDescription scene = Scene();
  scene.faults.grazing_holes = true;
  EXPECT_EQ(NumHoles(Sense(TurnedWall(2, 1.5), scene)), all);
  EXPECT_EQ(NumHoles(Sense(TurnedWall(2, 1.0), scene)), 0);

  scene = Scene();
  scene.faults.range_limits = true;
  EXPECT_EQ(NumHoles(Sense(Wall(scene.sensor.max_range_m + 0.1), scene)), all);
  EXPECT_EQ(NumHoles(Sense(Wall(scene.sensor.min_range_m - 0.1), scene)), all);
  EXPECT_EQ(NumHoles(Sense(Wall(2), scene)), 0);

  scene = Scene();
  scene.faults.dark_holes = true;
  SensedView wall = TurnedWall(5.5, 1.0);
  wall.reflectance = Image<float>(kCamera.width, kCamera.height, 0.0f);
  EXPECT_EQ(NumHoles(Sense(wall, scene)), all);
  wall.reflectance = Image<float>(kCamera.width, kCamera.height, 0.3f);
  EXPECT_EQ(NumHoles(Sense(wall, scene)), 0);
  // Black near by is seen.
  wall = Wall(2);
  wall.reflectance = Image<float>(kCamera.width, kCamera.height, 0.0f);
  EXPECT_EQ(NumHoles(Sense(wall, scene)), 0);
  wall.reflectance = Image<float>(kCamera.width, kCamera.height, 0.3f);
  EXPECT_EQ(NumHoles(Sense(wall, scene)), 0);

  scene = Scene();
  scene.faults.shiny_holes = true;
  wall = TurnedWall(2, 0.7);
  wall.shiny = Mask(kCamera.width, kCamera.height, 1);
  EXPECT_EQ(NumHoles(Sense(wall, scene)), all);
  EXPECT_EQ(NumHoles(Sense(TurnedWall(2, 0.7), scene)), 0);
}

TEST(DepthFaults, MissingShareIsMet) {
  SceneDescription scene = Scene();
  for (const double share : {0.3, 0.6, 1.0}) {
    scene.faults.missing_share = share;
    EXPECT_NEAR(NumHoles(Sense(Wall(2), scene)), share * kCamera.width * kCamera.height, 100);
  }
}

TEST(DepthFaults, MixedPixelsLieBetweenTheSurfacesAtTheEdgeOnly) {
  SceneDescription scene = Scene("kinect_v2");
  scene.faults.mixed_pixels = true;
  const DepthImage seen = Sense(Wall(3.0, 1.0, 160), scene);
  int num_mixed = 0;
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 0; u < kCamera.width; ++u) {
      const bool edge = u == 159 || u == 160;
      const float own = u < 160 ? 3.0f : 2.0f;
      EXPECT_TRUE(edge || seen(u, v) == own) << u;
      EXPECT_GE(seen(u, v), 2.0f);
      EXPECT_LE(seen(u, v), 3.0f);
      num_mixed += seen(u, v) != own ? 1 : 0;
    }
  }
  EXPECT_NEAR(num_mixed, scene.sensor.mixed_share * 2 * kCamera.height, 40);
}

TEST(DepthFaults, LateralNoiseMovesEdgesByItsDeviation) {
  for (const char* preset : {"kinect_v1", "d435"}) {
    SceneDescription scene = Scene(preset);
    scene.faults.lateral_noise = true;
    const SensedView wall = Wall(3.0, 1.0, 160);
    int num_wrong = 0;
    constexpr int kFrames = 10;
    for (std::uint64_t frame = 0; frame < kFrames; ++frame) {
      const DepthImage seen = ApplyDepthFaults(wall, kCamera, Pose3(), scene, {1, frame});
      for (int v = 0; v < kCamera.height; ++v) {
        for (int u = 0; u < kCamera.width; ++u)
          num_wrong += seen(u, v) != (u < 160 ? 3.0f : 2.0f) ? 1 : 0;
      }
    }
    // Rounded to pixels, the k-th column from the edge is wrong where the shift is larger than
    // k - 1/2 px towards it.
    double expected = 0;
    for (int k = 1; k < 8; ++k)
      expected += std::erfc((k - 0.5) / scene.sensor.lateral_px / std::sqrt(2.0));
    expected *= kFrames * kCamera.height;
    EXPECT_NEAR(num_wrong, expected, 0.08 * expected) << preset;
  }
}

TEST(DepthFaults, LateralDeviationGrowsWithTheAngleAsPublished) {
  const DepthSensor kinect = *DepthSensorPreset("kinect_v1");
  for (const double theta : {0.0, 0.5, 1.0, 1.4}) {
    EXPECT_NEAR(LateralDeviation(kinect, theta),
                0.8 + 0.035 * theta / (std::numbers::pi / 2 - theta),
                1e-12);
  }
}

TEST(DepthFaults, HolesOfMatchedWindowsArePatches) {
  const auto broken_runs = [](const std::string& preset) {
    SceneDescription scene = Scene(preset);
    scene.faults.dark_holes = true;
    SensedView wall = TurnedWall(10, 0);
    // A reflectance between those that are always and never seen from 10 m.
    const double between = 100 * 0.5 * (scene.sensor.signal_lost + scene.sensor.signal_sure);
    const double black = InfraredReflectance(0);
    wall.reflectance = Image<float>(
        kCamera.width, kCamera.height, static_cast<float>((between - black) / (1 - black)));
    const DepthImage seen = Sense(wall, scene);
    int num_holes = 0, num_changes = 0;
    for (int v = 0; v < kCamera.height; ++v) {
      for (int u = 1; u < kCamera.width; ++u) {
        num_holes += seen(u, v) == 0 ? 1 : 0;
        num_changes += (seen(u, v) == 0) != (seen(u - 1, v) == 0) ? 1 : 0;
      }
    }
    // Half are lost.
    EXPECT_NEAR(num_holes, 0.5 * kCamera.width * kCamera.height, 6000) << preset;
    return num_changes;
  };
  EXPECT_LT(2 * broken_runs("kinect_v1"), broken_runs("kinect_v2"));
}

TEST(DepthFaults, TheRimGivesNoDepth) {
  SceneDescription scene = Scene();
  scene.faults.rim = true;
  const DepthImage seen = Sense(Wall(2), scene);
  const auto& [left, right, top, bottom] = scene.sensor.rim;
  EXPECT_NEAR(NumHoles(seen),
              (1 - (1 - left - right) * (1 - top - bottom)) * kCamera.width * kCamera.height,
              kCamera.width + kCamera.height);
  EXPECT_EQ(seen(0, 120), 0);
  EXPECT_EQ(seen(319, 120), 0);
  EXPECT_EQ(seen(160, 0), 0);
  EXPECT_EQ(seen(160, 239), 0);
  EXPECT_EQ(seen(160, 120), 2);
}

TEST(DepthFaults, RangeBiasShiftsTheMean) {
  SceneDescription scene = Scene("d435");
  scene.faults.range_bias = true;
  EXPECT_NEAR(SpreadOf(Sense(Wall(3.0), scene), 3.0).mean_m, RangeBias(scene.sensor, 3.0), 1e-4);
  EXPECT_GT(RangeBias(scene.sensor, 3.0), 0.01);
}

TEST(DepthFaults, PhoneFillsInBetweenItsCells) {
  SceneDescription scene = Scene("phone_lidar");
  scene.faults.lateral_noise = true;
  const DepthImage seen = Sense(Wall(3.0, 1.0, 160), scene);
  int num_between = 0;
  for (int u = 0; u < kCamera.width; ++u)
    num_between += seen(u, 120) > 2.01f && seen(u, 120) < 2.99f ? 1 : 0;
  EXPECT_GE(num_between, 3);
  EXPECT_LE(num_between, scene.sensor.cell_px);
}

TEST(DepthFaults, SameSeedSameBytesOnAnyThreads) {
  SceneDescription scene;
  scene.faults.missing_share = 0.2;
  const DepthImage once = Sense(Wall(2.0, 0.8, 160), scene);
  const ThreadLimit one(1);
  EXPECT_EQ(Sense(Wall(2.0, 0.8, 160), scene), once);
}

TEST(DepthSensorPreset, UnknownNamesAreNone) {
  EXPECT_FALSE(DepthSensorPreset("kinect_v3").has_value());
  for (const std::string& name : DepthSensorPresetNames())
    EXPECT_TRUE(DepthSensorPreset(name).has_value()) << name;
}

TEST(MotionBlurred, SmearsAlongTheMotionAndLeavesStillPicturesAlone) {
  Image<Eigen::Vector3f> picture(64, 48, Eigen::Vector3f::Zero());
  for (int v = 0; v < 48; ++v) picture(32, v) = Eigen::Vector3f::Ones();
  const DepthImage depth(64, 48, 2.0f);
  const PinholeCamera camera{64, 48, 60, 60, 31.5, 23.5};
  EXPECT_EQ(MotionBlurred(picture, depth, camera, Pose3(), Pose3()), picture);
  // 0.2 m sideways at 2 m: 6 px.
  Pose3 moved;
  moved.translation_m.x() = 0.1;
  const Image<Eigen::Vector3f> blurred =
      MotionBlurred(picture, depth, camera, moved, moved.Inverse());
  float sum = 0;
  int width = 0;
  for (int u = 0; u < 64; ++u) {
    sum += blurred(u, 20).x();
    width += blurred(u, 20).x() > 0 ? 1 : 0;
  }
  EXPECT_NEAR(width, 6, 1.1);
  EXPECT_NEAR(sum, 1, 0.2);
}

TEST(DevelopColour, KeepsCleanGreysAndAddsLittleNoise) {
  const Image<Eigen::Vector3f> grey(64, 48, Eigen::Vector3f::Constant(0.2140f));
  const ColourImage clean = DevelopColour(grey, SensorFaults::None(), 1, {1, 1});
  EXPECT_EQ(clean(10, 10), (Rgb8{127, 127, 127}));
  const ColourImage noisy = DevelopColour(grey, SensorFaults(), 1, {1, 1});
  double sum = 0, sum_squares = 0;
  for (int v = 20; v < 28; ++v) {
    for (int u = 24; u < 40; ++u) {
      sum += noisy(u, v).g;
      sum_squares += noisy(u, v).g * noisy(u, v).g;
    }
  }
  const double mean = sum / 128;
  const double deviation = std::sqrt(sum_squares / 128 - mean * mean);
  EXPECT_NEAR(mean, 127, 4);
  EXPECT_GT(deviation, 0.3);
  EXPECT_LT(deviation, 6);
  EXPECT_LT(noisy(0, 0).g, noisy(32, 24).g + 5);
}

}  // namespace
}  // namespace deepslam::synth
