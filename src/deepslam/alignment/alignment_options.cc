#include "deepslam/alignment/alignment_options.h"

namespace deepslam::alignment {

void Describe(OptionsVisitor& visitor, AlignmentOptions& options) {
  Describe(visitor, options.pyramid);
  visitor.Field("photometric", options.photometric, "join a photometric term to ICP");
  visitor.Field("max_iterations", options.max_iterations, {1, 100}, "1", "iterations per level");
  visitor.Field("max_distance_m",
                options.max_distance_m,
                {0.01, 5},
                "m",
                "association gate at the coarsest level, halved at each finer one");
  visitor.Field("min_overlap",
                options.min_overlap,
                {0.01, 1},
                "1",
                "share of the points that must fall on valid points of the other frame");
  visitor.Field("min_agreement",
                options.min_inlier_ratio,
                {0.01, 1},
                "1",
                "share of the overlap that must agree within three standard deviations");
  visitor.Field("min_brightness_correlation",
                options.min_intensity_correlation,
                {-1, 1},
                "1",
                "correlation of the two images' intensities that an alignment must reach");
  visitor.Field("floor_translation_m",
                options.floor_translation_m,
                {0, 1},
                "m",
                "systematic error of an alignment, one standard deviation");
  visitor.Field("floor_rotation_deg",
                options.floor_rotation_deg,
                {0, 30},
                "deg",
                "systematic error of an alignment, one standard deviation");
}

}  // namespace deepslam::alignment
