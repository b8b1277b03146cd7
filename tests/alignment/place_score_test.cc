// Places are scored as steps to them would be.
#include "deepslam/alignment/place_score.h"

#include <cstddef>
#include <cstdint>

#include <gtest/gtest.h>

#include "alignment/box_world.h"
#include "alignment/rendered_pyramids.h"
#include "deepslam/alignment/alignment_system.h"
#include "deepslam/alignment/reference_pixels.h"
#include "deepslam/alignment/source_points.h"

namespace deepslam::alignment {
namespace {

using testing_support::Furnished;
using testing_support::LookAt;

const Pose3 kWorldFromI = LookAt({1.6, -1.9, 1.4}, {0, 0, 0.4});
const Pose3 kIFromJ = V2t((Vector6d() << 0.03, -0.02, 0.04, 0.02, -0.03, 0.01).finished());

TEST(ScorePlace, CountsAndComparesAsAStepDoes) {
  const FramePyramid i = Furnished(kWorldFromI), j = Furnished(kWorldFromI * kIFromJ, 2);
  for (const double off_m : {0.0, 0.05, 0.4}) {
    const Pose3 off{Eigen::Quaterniond::Identity(), {off_m, 0, 0}};
    for (std::size_t k = 0; k < i.levels.size(); ++k) {
      const SourcePoints points(j.levels[k], {1, true, false});
      const AlignmentGates gates;
      const AlignmentSystem step =
          BuildAlignmentSystem(i.levels[k], points, off * kIFromJ, gates, {});
      const PlaceScore place = ScorePlace(i.levels[k], points, off * kIFromJ, gates, {});
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

TEST(ScorePlace, BehindTheCameraNothingIsShared) {
  const FramePyramid i = Furnished(kWorldFromI);
  const SourcePoints points(i.levels.back(), {1, true, false});
  const Pose3 behind = V2t((Vector6d() << 0, 0, 0, 0, 3, 0).finished());
  const PlaceScore place = ScorePlace(i.levels.back(), points, behind, {}, {});
  EXPECT_EQ(place.num_overlap, 0);
  EXPECT_EQ(place.num_photometric, 0);
  EXPECT_EQ(place.support, 0);
  EXPECT_EQ(place.intensity_correlation, 0);
}

}  // namespace
}  // namespace deepslam::alignment
