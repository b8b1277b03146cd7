// Ends of iterations held against where they began, along directions that depth does not show.
//
// Of a wall that meets a floor there are images to compare, but along the edge they are alike
// wherever the camera is: what noise, blocks of JPEG files and the steps of the edge itself leave
// would carry an alignment along by decimetres.
#pragma once

#include "deepslam/alignment/alignment_options.h"
#include "deepslam/alignment/gauss_newton.h"
#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/alignment/source_points.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::alignment {

// Where iterations end.
struct FinestLevel {
  const PyramidLevel& i;
  const SourcePoints& j;
  int batch_stride;  // by every how many batches of points the end is measured
  const AlignmentOptions& options;
};

// Where they began, and how well that is known.
struct FirstStart {
  Pose3 i_from_j;
  StartSigma sigma;
};

// The system at the end of iterations, of both frames' normals and gradients.
void MeasureEnd(const FinestLevel& finest, GaussNewtonState& state);

// Of the places from the start to the end along the directions that depth does not show, the
// nearest to the start that is not surely less likely than another (kSureNats), by how alike images
// are there and how well the start is known. At each the iterations have gone on in the other
// directions. Without images that is the start (solution remapping: Zhang, Kaess, Singh 2016).
// `end` where nothing is held; elsewhere `fixed` has the directions.
[[nodiscard]] GaussNewtonState Remapped(const FinestLevel& finest,
                                        const FirstStart& start,
                                        const GaussNewtonState& end);

}  // namespace deepslam::alignment
