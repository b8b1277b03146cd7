// Alignment of two RGB-D frames: robust point-to-plane ICP with projective association, coarse to
// fine, joined with a photometric term where colour is there and asked for.
//
// Frame i is the reference, frame j the source. Geometric residual of source point p_j:
// n_i . (T p_j - q_i), q_i the point of frame i seen at the pixel of T p_j. Photometric residual:
// I_i(pixel of T p_j) - (gain * I_j + bias + lens's falloff). Both are divided by their standard
// deviations (depth noise model times the larger noise_scale of the two pyramids; spread of the
// residuals themselves), weighted as Student-t, nu = 5 (Kerl 2013). Each term counts by its
// independent measurements (see FrameAlignment::information), and where both are there, depth by
// what its directions have beyond the noise of the normals: intensity fills the directions that
// depth leaves weak, and does not outvote depth where it is strong.
#pragma once

#include <span>

#include "deepslam/alignment/alignment_options.h"
#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/alignment/start_search.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::alignment {

struct FrameAlignment {
  bool ok = false;          // otherwise the rest is the best found, not to be trusted
  bool degenerate = false;  // aligned, but a direction is weakly constrained
  // A degenerate direction that nothing measures stayed as the first start has it.
  bool remapped = false;
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
  double rmse_m = 0;                 // point-to-plane, over inliers
  double fitness = 0;                // inliers / valid source points
  double constraint_ratio = 0;       // weakest / strongest direction, what `degenerate` goes by
  double inlier_ratio = 0;           // inliers / overlapping points
  double intensity_correlation = 1;  // over textured points; 1 without colour
  double overlap_ratio = 0;  // source points on valid reference points / valid source points
  double inside_ratio = 0;   // source points inside the reference's image / valid source points
};

// Aligns j to i, a reference (reference_pixels.h), from the best of the given starts (at least one)
// and the one that `search` may find, which are tried at the coarsest level. Directions that
// nothing measures (a bare wall without colour) stay as the first start has them, and the
// information says no more of them than `start_sigma`.
[[nodiscard]] FrameAlignment AlignPyramids(const FramePyramid& i,
                                           const FramePyramid& j,
                                           std::span<const Pose3> initial_i_from_j,
                                           const AlignmentOptions& options,
                                           const StartSigma& start_sigma = {},
                                           const StartSearch& search = {});

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

}  // namespace deepslam::alignment
