#include "deepslam/alignment/frame_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "alignment/box_world.h"
#include "deepslam/alignment/reference_pixels.h"
#include "deepslam/core/random.h"
#include "support/pose_matchers.h"

namespace deepslam::alignment {
namespace {

using testing_support::BoxWorld;
using testing_support::kSmallCamera;
using testing_support::LookAt;
using testing_support::PoseNear;
using testing_support::RenderFrame;

// Noise of 160 x 120 depths at 2-3 m (about 1 cm), averaged over the independent ones among them.
constexpr double kToleranceM = 0.006;
constexpr double kToleranceDeg = 0.2;

const Pose3 kWorldFromI = LookAt({-1.6, -0.3, 1.4}, {0.5, 0.1, 0.5});
const Pose3 kIFromJ = V2t((Vector6d() << 0.06, -0.03, 0.05, 0.03, -0.05, 0.02).finished());

struct Pair {
  Frame i;
  Frame j;
};

Pair RenderPair(const BoxWorld& world,
                const Pose3& world_from_i,
                const Pose3& i_from_j,
                double noise,
                std::uint64_t seed = 1) {
  return {RenderFrame(world, world_from_i, noise, seed),
          RenderFrame(world, world_from_i * i_from_j, noise, seed + 1000)};
}

AlignmentOptions GeometryOnly() {
  AlignmentOptions options;
  options.photometric = false;
  return options;
}

FrameAlignment AlignFrames(const Frame& i,
                           const Frame& j,
                           const PinholeCamera& camera,
                           const Pose3& i_from_j,
                           const AlignmentOptions& options = {}) {
  return AlignPyramids(AsReference(BuildPyramid(i, camera, options.pyramid)),
                       BuildPyramid(j, camera, options.pyramid),
                       {&i_from_j, 1},
                       options);
}

double SmallestEigenvalue(const Matrix6d& matrix) {
  return Eigen::SelfAdjointEigenSolver<Matrix6d>(matrix).eigenvalues()[0];
}

TEST(AlignFrames, RecoversTheMotionWithAndWithoutColour) {
  const Pair pair = RenderPair(BoxWorld::Furnished(), kWorldFromI, kIFromJ, 1.0);
  for (const AlignmentOptions& options : {AlignmentOptions{}, GeometryOnly()}) {
    const FrameAlignment alignment = AlignFrames(pair.i, pair.j, kSmallCamera, Pose3{}, options);
    EXPECT_TRUE(alignment.ok);
    EXPECT_FALSE(alignment.degenerate);
    EXPECT_THAT(alignment.i_from_j, PoseNear(kIFromJ, kToleranceM, kToleranceDeg));
    EXPECT_GT(alignment.inlier_ratio, 0.85);
  }
}

// A robot's own body in the lowest fifth of the picture: a bowed plate half a metre away, speckled,
// that moves with the camera.
void ShowOwnBody(Frame& frame) {
  const int height = frame.depth_m.height();
  for (int v = height - height / 5; v < height; ++v) {
    for (int u = 0; u < frame.depth_m.width(); ++u) {
      frame.depth_m(u, v) = static_cast<float>(0.45 + 1e-5 * (u - 80) * (u - 80));
      const auto grey = static_cast<std::uint8_t>((u / 4 + v / 4) % 2 == 0 ? 70 : 110);
      frame.colour(u, v) = {grey, grey, grey};
    }
  }
}

TEST(AlignFrames, IsNotHeldByWhatMovesWithTheCamera) {
  Pair pair = RenderPair(BoxWorld::Furnished(), kWorldFromI, kIFromJ, 1.0);
  ShowOwnBody(pair.i);
  ShowOwnBody(pair.j);
  for (const AlignmentOptions& options : {AlignmentOptions{}, GeometryOnly()}) {
    const FrameAlignment alignment = AlignFrames(pair.i, pair.j, kSmallCamera, Pose3{}, options);
    EXPECT_TRUE(alignment.ok);
    EXPECT_THAT(alignment.i_from_j, PoseNear(kIFromJ, 2 * kToleranceM, 2 * kToleranceDeg));
  }
}

TEST(AlignFrames, ForwardTimesBackwardIsIdentity) {
  const Pair pair = RenderPair(BoxWorld::Furnished(), kWorldFromI, kIFromJ, 1.0);
  const FrameAlignment forward = AlignFrames(pair.i, pair.j, kSmallCamera, Pose3{});
  const FrameAlignment backward = AlignFrames(pair.j, pair.i, kSmallCamera, Pose3{});
  EXPECT_THAT(forward.i_from_j * backward.i_from_j, PoseNear(Pose3{}, kToleranceM, kToleranceDeg));
}

TEST(AlignFrames, ExactDepthOfTheSameViewGivesIdentity) {
  const Pair pair = RenderPair(BoxWorld::Furnished(), kWorldFromI, Pose3{}, 0.0);
  const Pose3 start = V2t((Vector6d() << 0.03, 0.02, -0.02, 0.02, -0.02, 0.01).finished());
  const FrameAlignment alignment = AlignFrames(pair.i, pair.j, kSmallCamera, start);
  EXPECT_THAT(alignment.i_from_j, PoseNear(Pose3{}, 1e-3, 0.03));
}

TEST(AlignFrames, InformationIsPositiveDefiniteAndNotOverconfident) {
  double sum_chi2 = 0;
  constexpr int kDraws = 12;
  for (int n = 0; n < kDraws; ++n) {
    const Pair pair =
        RenderPair(BoxWorld::Furnished(), kWorldFromI, kIFromJ, 1.0, static_cast<std::uint64_t>(n));
    const FrameAlignment alignment = AlignFrames(pair.i, pair.j, kSmallCamera, Pose3{});
    EXPECT_GT(SmallestEigenvalue(alignment.information), 0);
    EXPECT_EQ(alignment.information, alignment.information.transpose());
    const Vector6d error = T2v(alignment.i_from_j.Inverse() * kIFromJ);
    sum_chi2 += error.dot(alignment.information * error);
  }
  // Six degrees of freedom: a mean far above 6 is overconfident. The depth noise of this world is
  // independent from pixel to pixel while the information assumes it shared, so the mean lies
  // below.
  EXPECT_LT(sum_chi2 / kDraws, 12);
  EXPECT_GT(sum_chi2 / kDraws, 0.015);
}

// Highlights and shading that move with the camera: bumps of intensity some 40 pixels of a 640
// pixel wide image across.
ColourImage Blotched(const ColourImage& image, std::uint64_t seed) {
  Random random(seed, "blotches", 0);
  ColourImage blotched = image;
  for (int n = 0; n < 120; ++n) {
    const double at_u = random.Uniform(0, image.width());
    const double at_v = random.Uniform(0, image.height());
    const double height = random.Uniform(-50, 50);
    for (int v = 0; v < image.height(); ++v) {
      for (int u = 0; u < image.width(); ++u) {
        const double add = height * std::exp(-(std::pow(u - at_u, 2) + std::pow(v - at_v, 2)) / 50);
        Rgb8& pixel = blotched(u, v);
        for (std::uint8_t* const level : {&pixel.r, &pixel.g, &pixel.b})
          *level = static_cast<std::uint8_t>(std::clamp(std::lround(*level + add), 0L, 255L));
      }
    }
  }
  return blotched;
}

double ErrorM(const FrameAlignment& alignment, const Pose3& i_from_j) {
  return (alignment.i_from_j.translation_m - i_from_j.translation_m).norm();
}

TEST(AlignFrames, IntensityCountsAsOftenAsItsErrorsAreIndependent) {
  AlignmentOptions trusting;
  trusting.photometric_correlation_length_px = 1;
  double balanced_m = 0;
  double trusting_m = 0;
  for (std::uint64_t n = 0; n < 8; ++n) {
    Pair pair = RenderPair(BoxWorld::Furnished(), kWorldFromI, kIFromJ, 0.5, n);
    pair.i.colour = Blotched(pair.i.colour, 2 * n);
    pair.j.colour = Blotched(pair.j.colour, 2 * n + 1);
    balanced_m += ErrorM(AlignFrames(pair.i, pair.j, kSmallCamera, Pose3{}), kIFromJ);
    trusting_m += ErrorM(AlignFrames(pair.i, pair.j, kSmallCamera, Pose3{}, trusting), kIFromJ);
  }
  EXPECT_LT(balanced_m, 0.7 * trusting_m);
  EXPECT_LT(balanced_m / 8, kToleranceM);
}

TEST(RefineAlignment, EndsWhereTheFullSearchDoesWhenItsStartIsNear) {
  const Pair pair = RenderPair(BoxWorld::Furnished(), kWorldFromI, kIFromJ, 1.0);
  const PyramidOptions options;
  const FramePyramid i = AsReference(BuildPyramid(pair.i, kSmallCamera, options));
  const FramePyramid j = BuildPyramid(pair.j, kSmallCamera, options);
  const Pose3 off = V2t((Vector6d() << 0.02, -0.02, 0.01, 0.01, -0.01, 0.01).finished());
  const Pose3 start = off * kIFromJ;
  const FrameAlignment full = AlignPyramids(i, j, {&start, 1}, {});
  const FrameAlignment near = RefineAlignment(i, j, start, {});
  EXPECT_TRUE(near.ok);
  EXPECT_THAT(near.i_from_j, PoseNear(kIFromJ, kToleranceM, kToleranceDeg));
  EXPECT_THAT(near.i_from_j, PoseNear(full.i_from_j, 0.001, 0.03));
  EXPECT_NEAR(near.inlier_ratio, full.inlier_ratio, 0.01);
}

// Wherever a frame was placed, its edge is the same.
TEST(Sharpened, ForgetsTheStart) {
  const Pair pair = RenderPair(BoxWorld::Furnished(), kWorldFromI, kIFromJ, 1.0);
  const FramePyramid i = AsReference(BuildPyramid(pair.i, kSmallCamera, {}));
  const FramePyramid j = BuildPyramid(pair.j, kSmallCamera, {});
  const FrameAlignment placed = AlignPyramids(i, j, {&kIFromJ, 1}, {});
  ASSERT_TRUE(placed.ok);
  const FrameAlignment sharpened = Sharpened(placed, i, j, {});
  for (int axis = 0; axis < 6; ++axis) {
    Vector6d off = Vector6d::Zero();
    off[axis] = 0.003;
    FrameAlignment elsewhere = placed;
    elsewhere.i_from_j = V2t(off) * placed.i_from_j;
    const FrameAlignment again = Sharpened(elsewhere, i, j, {});
    EXPECT_THAT(again.i_from_j, PoseNear(sharpened.i_from_j, 0.0003, 0.01)) << axis;
  }
}

TEST(Sharpened, LeavesWhatIsNotOkOrRemapped) {
  const Pair pair = RenderPair(BoxWorld::Furnished(), kWorldFromI, kIFromJ, 1.0);
  const FramePyramid i = AsReference(BuildPyramid(pair.i, kSmallCamera, {}));
  const FramePyramid j = BuildPyramid(pair.j, kSmallCamera, {});
  FrameAlignment found;
  found.ok = false;
  found.i_from_j = V2t((Vector6d() << 0.01, 0, 0, 0, 0, 0).finished()) * kIFromJ;
  EXPECT_THAT(Sharpened(found, i, j, {}).i_from_j, PoseNear(found.i_from_j, 1e-12, 1e-9));
  found.ok = found.remapped = true;
  EXPECT_THAT(Sharpened(found, i, j, {}).i_from_j, PoseNear(found.i_from_j, 1e-12, 1e-9));
}

TEST(RefineAlignment, SaysWhenTheFramesDoNotAgreeOrAreNotThere) {
  const Pair pair = RenderPair(BoxWorld::Furnished(), kWorldFromI, kIFromJ, 1.0);
  const FramePyramid i = AsReference(BuildPyramid(pair.i, kSmallCamera, {}));
  const FramePyramid j = BuildPyramid(pair.j, kSmallCamera, {});
  const Pose3 elsewhere = V2t((Vector6d() << 0.9, 0.2, -0.5, 0, 0.8, 0).finished());
  EXPECT_FALSE(RefineAlignment(i, j, elsewhere, {}).ok);
  const Pose3 behind = V2t((Vector6d() << 0, 0, 0, 0, 3, 0).finished());
  EXPECT_FALSE(RefineAlignment(i, j, behind * kIFromJ, {}).ok) << "they share nothing there";
  EXPECT_FALSE(RefineAlignment({}, j, kIFromJ, {}).ok);
  EXPECT_FALSE(RefineAlignment(i, {}, kIFromJ, {}).ok);
}

TEST(AlignFrames, MoreStructureMeansMoreInformation) {
  const Pose3 facing_wall;
  const Pair wall = RenderPair(BoxWorld::Wall(), facing_wall, Pose3{}, 1.0);
  const Pair room = RenderPair(BoxWorld::Furnished(), kWorldFromI, Pose3{}, 1.0);
  const FrameAlignment on_wall = AlignFrames(wall.i, wall.j, kSmallCamera, Pose3{}, GeometryOnly());
  const FrameAlignment in_room = AlignFrames(room.i, room.j, kSmallCamera, Pose3{}, GeometryOnly());
  EXPECT_GT(SmallestEigenvalue(in_room.information), 10 * SmallestEigenvalue(on_wall.information));
}

TEST(AlignFrames, FlatWallIsDegenerateUnlessItsTextureHelps) {
  const Pose3 sideways = V2t((Vector6d() << 0.05, 0.03, 0, 0, 0, 0).finished());
  const Pair pair = RenderPair(BoxWorld::Wall(), Pose3{}, sideways, 0.3);
  EXPECT_TRUE(AlignFrames(pair.i, pair.j, kSmallCamera, Pose3{}, GeometryOnly()).degenerate);
  const FrameAlignment with_colour = AlignFrames(pair.i, pair.j, kSmallCamera, Pose3{});
  EXPECT_TRUE(with_colour.ok);
  EXPECT_FALSE(with_colour.degenerate);
  EXPECT_THAT(with_colour.i_from_j, PoseNear(sideways, kToleranceM, kToleranceDeg));
}

TEST(AlignFrames, OtherStartsCountForNothingWhereTheFirstEndsSurely) {
  const Pair pair = RenderPair(BoxWorld::Furnished(), kWorldFromI, kIFromJ, 0.3);
  const FramePyramid i = AsReference(BuildPyramid(pair.i, kSmallCamera, {}));
  const FramePyramid j = BuildPyramid(pair.j, kSmallCamera, {});
  const Pose3 far = kIFromJ * V2t((Vector6d() << 0.1, -0.1, 0.2, 0.1, 0.15, 0).finished());
  const std::array<Pose3, 2> near_first = {Pose3{}, far}, far_first = {far, Pose3{}};
  const FrameAlignment alone = AlignPyramids(i, j, {near_first.data(), 1}, {});
  ASSERT_GT(alone.intensity_correlation, 0.95);
  const FrameAlignment with_other = AlignPyramids(i, j, near_first, {});
  EXPECT_EQ(with_other.i_from_j.translation_m, alone.i_from_j.translation_m);
  EXPECT_EQ(with_other.i_from_j.rotation.coeffs(), alone.i_from_j.rotation.coeffs());
  const FrameAlignment far_alone = AlignPyramids(i, j, {&far, 1}, {});
  EXPECT_GT((far_alone.i_from_j.translation_m - kIFromJ.translation_m).norm(), 0.02)
      << "a start that leads elsewhere";
  EXPECT_THAT(AlignPyramids(i, j, far_first, {}).i_from_j,
              PoseNear(kIFromJ, kToleranceM, kToleranceDeg));
}

// Floor and wall leave the way along the wall open, and a start some tiles off looks as good there.
TEST(AlignFrames, FindsThePlaceAlongATiledWall) {
  BoxWorld hall;
  hall.room = {{-20, -20, 0}, {20, 2.6, 20}};
  hall.tile_m = 0.41;
  const Pose3 world_from_i = LookAt({0, 0, 1.5}, {0.3, 2.6, 0.7});
  const Pose3 world_from_j = LookAt({0.06, 0.02, 1.52}, {0.5, 2.6, 0.7});
  const Frame i = RenderFrame(hall, world_from_i, 1, 1);
  const Frame j = RenderFrame(hall, world_from_j, 1, 2);
  const Pose3 i_from_j = world_from_i.Inverse() * world_from_j;
  for (const double off_m : {-0.18, -0.1, 0.0, 0.1, 0.18}) {  // up to 0.44 of a tile
    const Pose3 along{Eigen::Quaterniond::Identity(), Eigen::Vector3d(off_m, 0, 0)};
    const Pose3 start = world_from_i.Inverse() * along * world_from_j;
    const FrameAlignment alignment = AlignFrames(i, j, kSmallCamera, start, {});
    EXPECT_TRUE(alignment.ok) << off_m;
    EXPECT_THAT(alignment.i_from_j, PoseNear(i_from_j, 0.01, 0.3)) << off_m;
  }
}

// A light wall over a dark floor correlates nearly as well anywhere along the wall, and the two
// frames have most in common where the camera did not move at all.
TEST(AlignFrames, StaysAtThePlaceAlongALightWallOverADarkFloor) {
  BoxWorld hall;
  hall.room = {{-20, -20, 0}, {20, 2.6, 20}};
  hall.floor_darker = 70;
  hall.texture = 0.12;
  hall.texture_fineness = 3;
  const Pose3 world_from_i = LookAt({0, 0, 1.5}, {0, 1.8, 0.5});
  const Frame i = RenderFrame(hall, world_from_i, 1, 1);
  for (const double aside_m : {-0.12, 0.06, 0.12}) {
    const Pose3 world_from_j = LookAt({aside_m, 0, 1.5}, {3 * aside_m, 1.8, 0.5});
    const Frame j = RenderFrame(hall, world_from_j, 1, 2);
    const Pose3 i_from_j = world_from_i.Inverse() * world_from_j;
    const FrameAlignment alignment = AlignFrames(i, j, kSmallCamera, i_from_j, {});
    EXPECT_TRUE(alignment.ok) << aside_m;
    EXPECT_THAT(alignment.i_from_j, PoseNear(i_from_j, 0.01, 0.3)) << aside_m;
  }
}

// Depth in steps of an eighth of a pixel of disparity, as a Kinect's.
Frame InSteps(Frame frame) {
  constexpr float kStepsTimesM = 580 * 0.075F * 8;
  for (float& z : frame.depth_m) {
    if (z > 0) z = kStepsTimesM / std::round(kStepsTimesM / z);
  }
  return frame;
}

// The steps form ridges on a bare wall that stay with the camera when it turns. Depth alone must
// not take them for the wall's.
TEST(AlignFrames, DepthAloneHoldsStillAlongABareWall) {
  BoxWorld hall;
  hall.room = {{-20, -20, 0}, {20, 2.6, 20}};
  const Pose3 world_from_i = LookAt({0, 0, 1.5}, {0.3, 2.6, 0.9});
  const Frame i = InSteps(RenderFrame(hall, world_from_i, 1, 1));
  for (const double turn_m : {-0.13, 0.13}) {
    const Pose3 world_from_j = LookAt({0.03, 0, 1.5}, {0.3 + turn_m, 2.6, 0.9});
    const Frame j = InSteps(RenderFrame(hall, world_from_j, 1, 2));
    const Pose3 i_from_j = world_from_i.Inverse() * world_from_j;
    const FrameAlignment alignment = AlignFrames(i, j, kSmallCamera, i_from_j, GeometryOnly());
    EXPECT_TRUE(alignment.ok) << turn_m;
    EXPECT_TRUE(alignment.degenerate) << turn_m;
    EXPECT_THAT(alignment.i_from_j, PoseNear(i_from_j, 0.01, 0.3)) << turn_m;
    // x of the camera is along the wall: no surer than the start.
    EXPECT_GT(std::sqrt(alignment.information.inverse()(0, 0)), 0.1) << turn_m;
  }
}

// Where the images' texture does not lie on itself, it says nothing about the place.
TEST(AlignFrames, TextureBesideItselfGivesNoInformation) {
  BoxWorld hall;
  hall.room = {{-20, -20, 0}, {20, 2.6, 20}};
  hall.floor_darker = 70;
  BoxWorld repainted = hall;
  repainted.texture_phase = 2;
  const Pose3 world_from_i = LookAt({0, 0, 1.5}, {0, 1.8, 0.5});
  const auto along_m = [&](const BoxWorld& before, const BoxWorld& after) {
    const Frame i = RenderFrame(before, world_from_i, 1, 1);
    const Frame j = RenderFrame(after, world_from_i, 1, 2);
    const FrameAlignment alignment = AlignFrames(i, j, kSmallCamera, Pose3{}, {});
    return std::sqrt(alignment.information.inverse()(0, 0));  // x of the camera is along the wall
  };
  EXPECT_LT(along_m(hall, hall), 0.01);
  EXPECT_GT(along_m(hall, repainted), 3 * along_m(hall, hall));
}

TEST(AlignFrames, ChangedExposureDoesNotMatter) {
  Pair pair = RenderPair(
      BoxWorld::Wall(), Pose3{}, V2t((Vector6d() << 0.05, 0.03, 0, 0, 0, 0).finished()), 0.3);
  const FrameAlignment plain = AlignFrames(pair.i, pair.j, kSmallCamera, Pose3{});
  for (Rgb8& pixel : pair.j.colour) {
    const auto darker = static_cast<std::uint8_t>(0.7 * pixel.r + 10);
    pixel = {darker, darker, darker};
  }
  const FrameAlignment darkened = AlignFrames(pair.i, pair.j, kSmallCamera, Pose3{});
  EXPECT_THAT(darkened.i_from_j, PoseNear(plain.i_from_j, 0.003, 0.1));
}

// As a lens does: by a share of the squared tangent of the angle with the optical axis.
Frame DarkenedTowardsTheCorners(Frame frame, double share) {
  for (int v = 0; v < kSmallCamera.height; ++v) {
    for (int u = 0; u < kSmallCamera.width; ++u) {
      const double rho2 = kSmallCamera.Ray(u, v).head<2>().squaredNorm();
      Rgb8& pixel = frame.colour(u, v);
      const auto grey = static_cast<std::uint8_t>(std::lround(pixel.r * (1 - share * rho2)));
      pixel = {grey, grey, grey};
    }
  }
  return frame;
}

// The darkening stays with the camera as it moves, and would hold it back along a wall.
TEST(AlignFrames, ADarkeningLensDoesNotMatter) {
  BoxWorld wall = BoxWorld::Wall();
  wall.texture = 0.15;
  for (const double aside_m : {-0.15, 0.15}) {
    const Pose3 aside{Eigen::Quaterniond::Identity(), Eigen::Vector3d(aside_m, 0, 0)};
    const Pair pair = RenderPair(wall, Pose3{}, aside, 0.3);
    const FrameAlignment alignment = AlignFrames(DarkenedTowardsTheCorners(pair.i, 0.4),
                                                 DarkenedTowardsTheCorners(pair.j, 0.4),
                                                 kSmallCamera,
                                                 aside);
    EXPECT_TRUE(alignment.ok) << aside_m;
    EXPECT_THAT(alignment.i_from_j, PoseNear(aside, 0.004, 0.2)) << aside_m;
  }
}

// Where what is in front is beside it, the picture of what is behind is blurred with it and moves
// as it does: here to where its neighbour on the left was.
Frame DraggedBehindOutlines(Frame frame) {
  const Frame before = frame;
  for (int v = 1; v + 1 < kSmallCamera.height; ++v) {
    for (int u = 1; u + 1 < kSmallCamera.width; ++u) {
      const float in_front_m = before.depth_m(u, v) - 0.3F;
      if (before.depth_m(u - 1, v) < in_front_m || before.depth_m(u + 1, v) < in_front_m)
        frame.colour(u, v) = before.colour(u - 1, v);
    }
  }
  return frame;
}

TEST(AlignFrames, WhatIsBehindAnOutlineDoesNotCount) {
  BoxWorld posts;
  posts.room = {{-20, -20, 0}, {20, 3, 20}};
  posts.texture = 0.4;
  for (double x = -1.5; x < 1.6; x += 0.15)
    posts.boxes.push_back({{x - 0.02, 1.4, 0}, {x + 0.02, 1.5, 20}});
  const Frame frame = RenderFrame(posts, LookAt({0, -0.6, 1.2}, {0, 3, 1.0}));
  const FrameAlignment alignment =
      AlignFrames(frame, DraggedBehindOutlines(frame), kSmallCamera, Pose3{});
  EXPECT_TRUE(alignment.ok);
  EXPECT_THAT(alignment.i_from_j, PoseNear(Pose3{}, 0.002, 0.05));
}

TEST(AlignFrames, UnrelatedViewsAreRefused) {
  BoxWorld other;
  other.texture_phase = 2;
  other.boxes = {{{-0.3, -0.2, 0}, {0.4, 1.0, 1.5}}};
  const Frame i = RenderFrame(BoxWorld::Furnished(), kWorldFromI, 1.0);
  const Frame j = RenderFrame(other, LookAt({1.5, 1.5, 1.0}, {-0.5, 0.2, 0.8}), 1.0);
  EXPECT_FALSE(AlignFrames(i, j, kSmallCamera, Pose3{}).ok);
}

TEST(AlignFrames, FramesWithoutUsableImagesAreRefused) {
  const Frame good = RenderFrame(BoxWorld::Furnished(), kWorldFromI, 0.0);
  Frame dark = good;
  dark.depth_m = DepthImage(kSmallCamera.width, kSmallCamera.height);
  Frame broken = good;
  for (float& z : broken.depth_m) z = std::numeric_limits<float>::quiet_NaN();
  Frame small = good;
  small.depth_m = DepthImage(3, 2, 1.0F);
  const Pose3 start = kIFromJ;
  for (const Frame& bad : {Frame{}, dark, broken, small}) {
    const FrameAlignment first = AlignFrames(good, bad, kSmallCamera, start);
    const FrameAlignment second = AlignFrames(bad, good, kSmallCamera, start);
    EXPECT_FALSE(first.ok);
    EXPECT_FALSE(second.ok);
    EXPECT_TRUE(first.i_from_j.translation_m.allFinite());
    EXPECT_TRUE(first.information.allFinite());
  }
}

}  // namespace
}  // namespace deepslam::alignment
