// What an alignment is worth as an edge of a pose graph: the information of its relative pose.
#pragma once

#include "deepslam/alignment/alignment_options.h"
#include "deepslam/alignment/gauss_newton.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::alignment {

struct EdgeInformation {
  // Of t2v(measured^-1 * true): FrameAlignment::information.
  Matrix6d information = Matrix6d::Identity();
  // Information of the weakest direction by that of the strongest, rotations measured by the arc at
  // the mean distance.
  double constraint_ratio = 0;
};

// Of iterations that have ended at the level `finest`, with a system of both frames' normals and
// gradients (AlignmentGates::cross_frames). Directions that nothing measures claim no more than
// `start_sigma`.
[[nodiscard]] EdgeInformation EdgeInformationOf(const GaussNewtonState& state,
                                                const PyramidLevel& finest,
                                                const StartSigma& start_sigma,
                                                const AlignmentOptions& options);

}  // namespace deepslam::alignment
