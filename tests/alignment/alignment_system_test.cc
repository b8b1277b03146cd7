#include "deepslam/alignment/alignment_system.h"

#include <cstddef>
#include <cstdint>

#include <gtest/gtest.h>

#include "alignment/box_world.h"
#include "alignment/rendered_pyramids.h"
#include "deepslam/alignment/batch_columns.h"
#include "deepslam/alignment/reference_pixels.h"
#include "deepslam/alignment/source_points.h"

namespace deepslam::alignment {
namespace {

using testing_support::Furnished;
using testing_support::LookAt;

const Pose3 kWorldFromI = LookAt({1.6, -1.9, 1.4}, {0, 0, 0.4});
const Pose3 kIFromJ = V2t((Vector6d() << 0.03, -0.02, 0.04, 0.02, -0.03, 0.01).finished());

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

}  // namespace
}  // namespace deepslam::alignment
