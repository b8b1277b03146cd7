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
#include "deepslam/alignment/weak_direction_search.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::alignment {

// Where iterations end.
struct FinestLevel {
  const FramePyramid& frame_i;
  const FramePyramid& frame_j;
  const PyramidLevel& i;  // of frame_i
  const SourcePoints& j;  // of frame_j
  int batch_stride;       // by every how many batches of points the end is measured
  const AlignmentOptions& options;
};

// The system at the end of iterations, of both frames' normals and gradients.
void MeasureEnd(const FinestLevel& finest, GaussNewtonState& state);

// The end brought to where fine texture has it along the directions that depth does not show
// (SearchTexture). Without, of the places from the start to the end along the directions that
// depth does not show, the nearest to the start that is not surely less likely than another
// (kSureNats), by how alike images are there and how well the start is known. At each the
// iterations have gone on in the other directions. Without images that is the start (solution
// remapping: Zhang, Kaess, Singh 2016). `end` where nothing is held; elsewhere `fixed` has the
// directions, and `fixed_sigma` how well texture shows the place along them.
[[nodiscard]] GaussNewtonState Remapped(const FinestLevel& finest,
                                        const FirstStart& start,
                                        const GaussNewtonState& end);

}  // namespace deepslam::alignment
