// What frame j brings to an alignment is what it would show as a target; places are judged as steps
// to them would be.
#include "deepslam/alignment/source_points.h"

#include <cstddef>
#include <cstdint>

#include <gtest/gtest.h>

#include "alignment/box_world.h"
#include "deepslam/alignment/batch_columns.h"
#include "deepslam/alignment/place_judgement.h"
#include "deepslam/alignment/point_alignment.h"
#include "deepslam/alignment/reference_pixels.h"

namespace deepslam::alignment {
namespace {

using testing_support::BoxWorld;
using testing_support::kSmallCamera;
using testing_support::LookAt;
using testing_support::RenderFrame;

FramePyramid Furnished(const Pose3& world_from_camera, std::uint64_t seed = 1) {
  const Frame frame = RenderFrame(BoxWorld::Furnished(), world_from_camera, 1.0, seed);
  return AsReference(BuildPyramid(frame, kSmallCamera, {}));
}

const Pose3 kWorldFromI = LookAt({1.6, -1.9, 1.4}, {0, 0, 0.4});
const Pose3 kIFromJ = V2t((Vector6d() << 0.03, -0.02, 0.04, 0.02, -0.03, 0.01).finished());

bool Equal(const PackedTexel& packed, const SurfaceTexel& texel) {
  return packed.a == texel.nx && packed.b == texel.ny && packed.c == texel.nz &&
         packed.d == texel.offset_m;
}

bool Equal(const PackedTexel& packed, const IntensityTexel& texel) {
  return packed.a == texel.value && packed.b == texel.du && packed.c == texel.dv;
}

TEST(SourcePoints, ShowWhatTheFrameShowsAsATarget) {
  for (const PyramidLevel& level : Furnished(kWorldFromI).levels) {
    for (const int stride : {1, 3}) {
      const SourcePoints points(level, {stride, true, true});
      int num_points = 0;
      for (const SourceRow& row : points.rows()) {
        for (std::size_t n = row.begin; n < row.end; ++n) {
          if (!(points.depth_m()[n] > 0)) continue;  // fills the lanes
          const std::size_t texel = static_cast<std::size_t>(row.v * level.camera.width +
                                                             static_cast<int>(points.column()[n]));
          EXPECT_EQ(points.depth_m()[n], level.depth_m[texel]);
          EXPECT_TRUE(Equal(points.surface()[n], level.surface[texel])) << row.v;
          EXPECT_TRUE(Equal(points.intensity()[n], level.intensity[texel])) << row.v;
          EXPECT_EQ(points.has_normal()[n], level.surface[texel].offset_m < 0 ? 1 : 0);
          ++num_points;
        }
      }
      EXPECT_GT(num_points, level.camera.width * level.camera.height / (2 * stride * stride));
    }
  }
}

TEST(SourcePoints, WithoutBrightnessHaveNoTexture) {
  const FramePyramid pyramid = Furnished(kWorldFromI);
  const SourcePoints points(pyramid.levels.front(), {2, false, false});
  ASSERT_GT(points.size(), 0U);
  for (std::size_t n = 0; n < points.size(); ++n) EXPECT_EQ(points.has_texture()[n], 0);
}

// Bands of rows stand for those between them.
TEST(BuildAlignmentSystem, IsTheSameOfEverySecondBatchButForChance) {
  const FramePyramid i = Furnished(kWorldFromI), j = Furnished(kWorldFromI * kIFromJ, 2);
  const SourcePoints points(j.levels.front(), {1, true, true});
  ASSERT_GT(points.size(), 40 * kBatch);
  for (const bool cross_frames : {false, true}) {
    AlignmentGates gates;
    gates.cross_frames = cross_frames;
    const AlignmentSystem all = BuildAlignmentSystem(i.levels.front(), points, kIFromJ, gates, {});
    EXPECT_EQ(all.num_source, points.num_with_normal());
    gates.batch_stride = 2;
    const AlignmentSystem half = BuildAlignmentSystem(i.levels.front(), points, kIFromJ, gates, {});
    const auto expect_near = [](double a, double b) { EXPECT_NEAR(a, b, 0.1 * b); };
    EXPECT_NE(half.num_matched, all.num_matched);
    expect_near(half.num_source, all.num_source);
    expect_near(half.num_inside, all.num_inside);
    expect_near(half.num_overlap, all.num_overlap);
    expect_near(half.num_matched, all.num_matched);
    expect_near(half.num_inliers, all.num_inliers);
    expect_near(half.num_photometric, all.num_photometric);
    expect_near(half.sum_squared_m2, all.sum_squared_m2);
    expect_near(half.intensity_correlation, all.intensity_correlation);
    expect_near(half.geometric_scale, all.geometric_scale);
    for (int k = 0; k < 6; ++k) {
      EXPECT_NEAR(half.hessian(k, k), all.hessian(k, k), 0.15 * all.hessian(k, k)) << k;
      EXPECT_NEAR(half.photometric_hessian(k, k),
                  all.photometric_hessian(k, k),
                  0.2 * all.photometric_hessian(k, k))
          << k;
    }
  }
}

TEST(JudgePlace, CountsAndComparesAsAStepDoes) {
  const FramePyramid i = Furnished(kWorldFromI), j = Furnished(kWorldFromI * kIFromJ, 2);
  for (const double off_m : {0.0, 0.05, 0.4}) {
    const Pose3 off{Eigen::Quaterniond::Identity(), {off_m, 0, 0}};
    for (std::size_t k = 0; k < i.levels.size(); ++k) {
      const SourcePoints points(j.levels[k], {1, true, false});
      const AlignmentGates gates;
      const AlignmentSystem step =
          BuildAlignmentSystem(i.levels[k], points, off * kIFromJ, gates, {});
      const PlaceJudgement place = JudgePlace(i.levels[k], points, off * kIFromJ, gates, {});
      EXPECT_EQ(place.num_source, step.num_source);
      EXPECT_EQ(place.num_overlap, step.num_overlap);
      EXPECT_EQ(place.num_photometric, step.num_photometric);
      EXPECT_NEAR(place.intensity_correlation, step.intensity_correlation, 1e-4);
      // A weight is at most 6/5, and at 3 sigmas, where inliers end, 6/14.
      EXPECT_LE(place.support, 1.2 * step.num_matched);
      EXPECT_GE(place.support, 6.0 / 14 * step.num_inliers - 1e-3);
    }
  }
}

TEST(JudgePlace, BehindTheCameraNothingIsShared) {
  const FramePyramid i = Furnished(kWorldFromI);
  const SourcePoints points(i.levels.back(), {1, true, false});
  const Pose3 behind = V2t((Vector6d() << 0, 0, 0, 0, 3, 0).finished());
  const PlaceJudgement place = JudgePlace(i.levels.back(), points, behind, {}, {});
  EXPECT_EQ(place.num_overlap, 0);
  EXPECT_EQ(place.num_photometric, 0);
  EXPECT_EQ(place.support, 0);
  EXPECT_EQ(place.intensity_correlation, 0);
}

}  // namespace
}  // namespace deepslam::alignment
