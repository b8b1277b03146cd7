// How well two frames fit at a place, without asking where a better one lies: what places that
// compete are told apart by. A part of what alignment_system.h makes a step of.
#pragma once

#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/alignment/plane_match.h"
#include "deepslam/alignment/source_points.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::alignment {

struct PlaceScore {
  int num_source = 0;   // points of j with a normal
  int num_overlap = 0;  // of those that fall on valid points of i, near or far
  int num_photometric = 0;
  double support =
      0;  // sum of the geometric residuals' Student-t weights, of those within the gates
  double intensity_correlation = 0;  // over the photometric pairs
};

// Of points that were chosen as for a place far off (SourceChoice::near is false).
[[nodiscard]] PlaceScore ScorePlace(const PyramidLevel& i,
                                    const SourcePoints& j,
                                    const Pose3& i_from_j,
                                    const CorrespondenceGates& gates,
                                    const DepthNoise& noise);

}  // namespace deepslam::alignment
