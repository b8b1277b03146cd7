// Pictures of a plane through lenses, drawn here ray by ray, against what a pinhole sees of it.
#include "deepslam/dataset/rectified_frames.h"

#include <cmath>

#include <gmock/gmock.h>

#include "deepslam/core/every_nth.h"

namespace deepslam::dataset {
namespace {

constexpr double kUnitsPerM = 5000;
const PinholeCamera kCamera{160, 120, 110, 112, 78, 61};
// Of the pattern on the picture plane, px of the pinhole: coarse enough to be sampled where a barrel
// squeezes it to a quarter, fine enough that a fifth of a pixel shows.
constexpr double kPeriodPx = 40;
constexpr double kAmplitude = 110;

// A tilted wall: n . p = d.
double DepthAt(const Eigen::Vector2d& pinhole) {
  return 1.5 / Eigen::Vector3d(0.3, -0.2, 1).dot(Eigen::Vector3d(pinhole.x(), pinhole.y(), 1));
}
double Wave(double px) { return 128 + kAmplitude * std::sin(2 * M_PI * px / kPeriodPx); }
// What a pinhole sees in that direction: two waves across each axis, so that one has a slope.
Eigen::Vector2d ColourAt(const PinholeCamera& camera, const Eigen::Vector2d& pinhole) {
  return {Wave(camera.fx * pinhole.x() + camera.cx), Wave(camera.fy * pinhole.y() + camera.cy)};
}

// The direction that a lens shows there.
Eigen::Vector2d Undistort(const LensDistortion& lens, const Eigen::Vector2d& shown) {
  Eigen::Vector2d at = shown;
  for (int k = 0; k < 200; ++k) at += 0.7 * (shown - lens.Distort(at));
  return at;
}

class DrawnFrames final : public StoredFrames {
 public:
  DrawnFrames(const PinholeCamera& camera,
              std::vector<PinholeCamera> taken,
              const LensDistortion& lens)
      : StoredFrames({camera, camera, Pose3(), kUnitsPerM}, std::vector<StoredFrame>(taken.size())),
        taken_(std::move(taken)),
        lens_(lens) {}

  [[nodiscard]] Result<StoredColour> ReadColour(std::size_t i) const override {
    StoredColour colour;
    colour.pixels = ColourImage(taken_[i].width, taken_[i].height);
    for (int v = 0; v < taken_[i].height; ++v) {
      for (int u = 0; u < taken_[i].width; ++u) {
        const Eigen::Vector2d seen = ColourAt(cameras().colour, DirectionAt(i, u, v));
        colour.pixels(u, v) = {static_cast<std::uint8_t>(std::lround(seen.x())),
                               static_cast<std::uint8_t>(std::lround(seen.y())),
                               200};
      }
    }
    return colour;
  }
  [[nodiscard]] Result<RawDepthImage> ReadDepth(std::size_t i) const override {
    RawDepthImage depth(taken_[i].width, taken_[i].height);
    for (int v = 0; v < taken_[i].height; ++v) {
      for (int u = 0; u < taken_[i].width; ++u)
        depth(u, v) =
            static_cast<std::uint16_t>(std::lround(kUnitsPerM * DepthAt(DirectionAt(i, u, v))));
    }
    return depth;
  }
  [[nodiscard]] std::shared_ptr<const StoredFrames> Every(std::size_t step) const override {
    return std::make_shared<DrawnFrames>(cameras().colour, EveryNth(taken_, step), lens_);
  }

 private:
  [[nodiscard]] Eigen::Vector2d DirectionAt(std::size_t i, int u, int v) const {
    return Undistort(lens_, taken_[i].Ray(u, v).head<2>());
  }

  std::vector<PinholeCamera> taken_;
  LensDistortion lens_;
};

struct Fault {
  double colour_px = 0;  // largest, where the pattern has a slope
  double depth_m = 0;
  int num_shown = 0;
};

// Of frame i against what the common pinhole sees.
Fault Compare(const StoredFrames& frames, std::size_t i) {
  const PinholeCamera& camera = frames.cameras().colour;
  const Result<StoredColour> colour = frames.ReadColour(i);
  const Result<RawDepthImage> depth = frames.ReadDepth(i);
  EXPECT_TRUE(colour.ok() && depth.ok());
  Fault fault;
  // Steepest: levels a pixel. Rounding and interpolation make 4 levels of it.
  const double slope = kAmplitude * 2 * M_PI / kPeriodPx;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      if ((*depth)(u, v) == 0) continue;
      ++fault.num_shown;
      const Eigen::Vector2d at = camera.Ray(u, v).head<2>();
      const Rgb8 read = colour->pixels(u, v);
      const Eigen::Vector2d truth = ColourAt(camera, at);
      for (const double off : {read.r - truth.x(), read.g - truth.y()})
        fault.colour_px = std::max(fault.colour_px, std::abs(off) / slope);
      fault.depth_m = std::max(fault.depth_m, std::abs((*depth)(u, v) / kUnitsPerM - DepthAt(at)));
    }
  }
  return fault;
}

struct Lens {
  std::string name;
  LensDistortion lens;
};
void PrintTo(const Lens& lens, std::ostream* out) { *out << lens.name; }

class RectifyFramesThrough : public testing::TestWithParam<Lens> {};

// The measure of the design: within 0.3 px and 1 mm of the undistorted capture.
TEST_P(RectifyFramesThrough, ShowsWhatAPinholeShows) {
  const LensDistortion& lens = GetParam().lens;
  const auto taken = std::make_shared<DrawnFrames>(kCamera, std::vector{kCamera, kCamera}, lens);
  EXPECT_GT(Compare(*taken, 0).colour_px, 1) << "the lens moves what is seen";
  const auto frames = RectifyFrames(taken, Optics{lens, lens, {}, {}});
  const Fault fault = Compare(*frames, 1);
  EXPECT_LE(fault.colour_px, 0.3);
  EXPECT_LE(fault.depth_m, 0.001);
  EXPECT_GT(fault.num_shown, kCamera.width * kCamera.height / 2);
}

INSTANTIATE_TEST_SUITE_P(
    All,
    RectifyFramesThrough,
    testing::Values(
        Lens{"Barrel", {LensModel::kRadialTangential, {-0.3}}},
        Lens{"Pincushion", {LensModel::kRadialTangential, {0.15}}},
        Lens{"Tangential", {LensModel::kRadialTangential, {-0.2, 0.05, 0.004, -0.006, 0.01}}},
        Lens{"Rational",
             {LensModel::kRational, {0.4, -0.3, 0.0005, -0.0003, 0.01, 0.8, -0.2, 0.02}}},
        Lens{"Fisheye", {LensModel::kFisheye, {-0.02, 0.01, 0.002, -0.001}}}),
    [](const auto& test) { return test.param.name; });

TEST(RectifyFrames, ColourAndDepthHaveLensesOfTheirOwn) {
  const LensDistortion lens{LensModel::kRadialTangential, {-0.3}};
  const auto taken = std::make_shared<DrawnFrames>(kCamera, std::vector{kCamera}, lens);
  const auto colour_alone = RectifyFrames(taken, Optics{lens, std::nullopt, {}, {}});
  EXPECT_EQ(*colour_alone->ReadDepth(0), *taken->ReadDepth(0));
  EXPECT_NE(colour_alone->ReadColour(0)->pixels, taken->ReadColour(0)->pixels);
  const auto depth_alone = RectifyFrames(taken, Optics{std::nullopt, lens, {}, {}});
  EXPECT_NE(*depth_alone->ReadDepth(0), *taken->ReadDepth(0));
  EXPECT_EQ(depth_alone->ReadColour(0)->pixels, taken->ReadColour(0)->pixels);
}

TEST(RectifyFrames, WithoutALensFramesPassAsTheyAre) {
  const auto taken = std::make_shared<DrawnFrames>(
      kCamera, std::vector{kCamera}, LensDistortion{LensModel::kRadialTangential, {}});
  const LensDistortion none{LensModel::kRational, {}};
  EXPECT_EQ(RectifyFrames(taken, Optics{none, none, {kCamera}, {kCamera}}), taken);
}

// A phone refocuses: each frame has a camera of its own.
TEST(RectifyFrames, FramesOfOtherCamerasBecomeTheCommonOnes) {
  PinholeCamera other = kCamera;
  other.fx *= 1.06;
  other.fy *= 1.06;
  other.cx += 3;
  const std::vector<PinholeCamera> cameras = {kCamera, other, kCamera, other};
  const auto taken = std::make_shared<DrawnFrames>(
      kCamera, cameras, LensDistortion{LensModel::kRadialTangential, {}});
  EXPECT_GT(Compare(*taken, 1).colour_px, 1);
  const auto frames = RectifyFrames(taken, Optics{std::nullopt, std::nullopt, cameras, cameras});
  for (const std::size_t i : {0U, 1U, 3U}) {
    const Fault fault = Compare(*frames, i);
    EXPECT_LE(fault.colour_px, 0.3) << i;
    EXPECT_LE(fault.depth_m, 0.001) << i;
  }
  EXPECT_EQ(*frames->ReadDepth(0), *taken->ReadDepth(0)) << "nothing to do";
  const auto some = frames->Every(3);
  ASSERT_EQ(some->frames().size(), 2U);
  EXPECT_EQ(*some->ReadDepth(1), *frames->ReadDepth(3));
}

TEST(RectifyFrames, WhereTheLensShowsNothingNothingIsSeen) {
  // Turns back on itself within the picture.
  const LensDistortion lens{LensModel::kRadialTangential, {-1.2}};
  const auto taken = std::make_shared<DrawnFrames>(kCamera, std::vector{kCamera}, lens);
  const auto frames = RectifyFrames(taken, Optics{lens, lens, {}, {}});
  EXPECT_EQ((*frames->ReadDepth(0))(0, 0), 0);
  EXPECT_EQ(frames->ReadColour(0)->pixels(0, 0), Rgb8{});
  EXPECT_GT((*frames->ReadDepth(0))(78, 61), 0);
}

}  // namespace
}  // namespace deepslam::dataset
