// Alignment of two RGB-D frames: robust point-to-plane ICP with projective association, coarse to
// fine, joined with a photometric term where colour is there and asked for.
//
// Geometric residual of source point p_j: n_i . (T p_j - q_i), q_i the point of frame i seen at the
// pixel of T p_j. Photometric residual: I_i(pixel of T p_j) - (gain * I_j + bias + lens's falloff).
// Both are divided by their standard deviations (depth noise model times the larger noise_scale of
// the two pyramids; spread of the residuals themselves), weighted as Student-t, nu = 5 (Kerl 2013).
// Each term counts by its independent measurements (see FrameAlignment::information), and where
// both are there, depth by what its directions have beyond the noise of the normals: brightness
// fills the directions that depth leaves weak, and does not outvote depth where it is strong.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/core/options.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::alignment {

struct AlignmentOptions {
  PyramidOptions pyramid;
  bool photometric = true;
  int max_iterations = 12;       // per level
  double max_distance_m = 0.30;  // association gate at the coarsest level, halved at each finer one
  double max_normal_angle_deg = 50;  // between the two normals of a correspondence
  double min_overlap = 0.20;         // of the source's points that fall on points of the target
  // Inliers of the overlap; good ones have 0.85 and more. Images that correlate by 0.9 make 0.6 of
  // it enough.
  double min_inlier_ratio = 0.60;
  // Correlation of the two intensities, judged where there is colour and structure.
  double min_intensity_correlation = 0.4;
  // Lengths over which errors are shared, in pixels of a 640 pixel wide image; see `information`.
  double correlation_length_px = 9;               // of depth
  double photometric_correlation_length_px = 25;  // of brightness: highlights, shading, vignetting
  // Systematic part of the error of one alignment, one standard deviation.
  double floor_translation_m = 0.002;
  double floor_rotation_deg = 0.1;
  // Degenerate when the weakest direction has less than this share of the strongest one's
  // information, rotations measured by the arc at the mean distance.
  double degenerate_ratio = 0.001;
};

void Describe(OptionsVisitor& visitor, AlignmentOptions& options);

struct FrameAlignment {
  bool ok = false;          // otherwise the rest is the best found, not to be trusted
  bool degenerate = false;  // aligned, but a direction is weakly constrained
  bool held = false;        // a direction that nothing measures stayed as the first start has it
  Pose3 i_from_j;
  // Information of t2v(measured^-1 * true), order (translation m; rotation rad), positive definite:
  // ((sum over both terms of J^T W J / k)^-1 + F)^-1 with J at the solution, correspondences fixed
  // (of the products of both frames' normals and gradients: see AlignmentGates::cross_frames).
  // Residuals of neighbouring pixels share their error (a structured-light sensor matches blocks of
  // about 9 x 9 pixels; highlights and shading are wider still), so J^T W J of all pixels counts
  // each measurement k = (correlation length in pixels of the working level)^2 times; F is the
  // systematic error (calibration, rolling shutter, quantisation) that more pixels do not average
  // away.
  Matrix6d information = Matrix6d::Identity();
  double rmse_m = 0;            // point-to-plane, over inliers
  double inlier_share = 0;      // inliers / valid source points
  double constraint_ratio = 0;  // weakest / strongest direction, what `degenerate` is judged by
  double inlier_ratio = 0;      // inliers / overlapping points
  double intensity_correlation = 1;  // over textured points; 1 without colour
  double overlap = 0;  // source points that fall on valid target points / valid source points
  double inside = 0;   // source points that fall inside the target image / valid source points
};

// How well the first start is known, one standard deviation.
struct StartSigma {
  double translation_m = 0.2;
  double rotation_rad = 0.2;
};

// Beside the first start, which is enough where it ends surely.
struct OtherStarts {
  std::function<std::optional<Pose3>()> search;  // another i_from_j, if one is found
  bool always = false;                           // however surely the first one ends
};

// Aligns j to i, a target (reference_pixels.h), from the best of the given starts (at least one)
// and the one that `others` may find, which are tried at the coarsest level. Directions that
// nothing measures (a bare wall without colour) stay as the first start has them, and the
// information says no more of them than `start_sigma`.
[[nodiscard]] FrameAlignment AlignPyramids(const FramePyramid& i,
                                           const FramePyramid& j,
                                           std::span<const Pose3> initial_i_from_j,
                                           const AlignmentOptions& options,
                                           const StartSigma& start_sigma = {},
                                           const OtherStarts& others = {});

// The same from one start that is near, within a few centimetres and degrees: the finest levels
// alone, and nothing else is tried; not ok without a look where the start leaves too little
// overlap.
[[nodiscard]] FrameAlignment RefineAlignment(const FramePyramid& i,
                                             const FramePyramid& j,
                                             const Pose3& i_from_j,
                                             const AlignmentOptions& options);

// An alignment to its end, for what is built on it: frames are placed to a twentieth of a pixel of
// the finest level, which is less than their noise, but leans towards where the camera was
// expected. Of `found`, an outcome of AlignPyramids for the same frames. It stays as it is where it
// is not ok or has a direction of its start, and where its end is not ok.
[[nodiscard]] FrameAlignment Sharpened(const FrameAlignment& found,
                                       const FramePyramid& i,
                                       const FramePyramid& j,
                                       const AlignmentOptions& options);

// How well j agrees with i, a target, where an alignment has laid it: robustly, per source point
// and at common scales, so that outcomes can be compared. Larger is better; 0 where they share
// nothing.
[[nodiscard]] double Support(const FramePyramid& i,
                             const FramePyramid& j,
                             const Pose3& i_from_j,
                             const AlignmentOptions& options);

}  // namespace deepslam::alignment
