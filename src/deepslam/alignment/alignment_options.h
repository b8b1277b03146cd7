// What an alignment of two frames may be asked for, and what is known before it.
#pragma once

#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/core/options.h"

namespace deepslam::alignment {

struct AlignmentOptions {
  PyramidOptions pyramid;
  bool photometric = true;
  int max_iterations = 12;       // per level
  double max_distance_m = 0.30;  // association gate at the coarsest level, halved at each finer one
  // Between the two normals of a correspondence: noise turns single ones by tens of degrees, and
  // surfaces that meet at a corner are turned by more.
  static constexpr double kMaxNormalAngle_deg = 50;
  double min_overlap = 0.20;  // of the source's points that fall on points of the reference
  // Inliers of the overlap; good ones have 0.85 and more. Images that correlate by 0.9 make 0.6 of
  // it enough.
  double min_inlier_ratio = 0.60;
  // Correlation of the two intensities, asked for where there is colour and structure.
  double min_intensity_correlation = 0.4;
  // Lengths over which errors are shared, in pixels of a 640 pixel wide image; see
  // FrameAlignment::information.
  double correlation_length_px = 9;               // of depth
  double photometric_correlation_length_px = 25;  // of intensity: highlights, shading, vignetting
  // Systematic part of the error of one alignment, one standard deviation.
  double floor_translation_m = 0.002;
  double floor_rotation_deg = 0.1;
  // Degenerate when the weakest direction has less than this share of the strongest one's
  // information, a deviation 30 times as large; rotations count by the arc at the mean distance.
  static constexpr double kDegenerateRatio = 0.001;
};

void Describe(OptionsVisitor& visitor, AlignmentOptions& options);

// How well the first start is known, one standard deviation.
struct StartSigma {
  double translation_m = 0.2;
  double rotation_rad = 0.2;
};
// Of a prediction from two alignments, beside what the hand does: where somebody walks through they
// are off by several centimetres.
inline constexpr StartSigma kPredictionSigma{0.02, 0.016};

}  // namespace deepslam::alignment
