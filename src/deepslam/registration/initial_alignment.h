// Where a model may stand, from one view: ordinary Procrustes alignment by moments over quantised
// azimuths.
//
// Paper, "camera-to-model pose estimation": for each azimuth the model's partial view, left by
// orthographic occlusion along a horizontal direction towards its centre, is brought onto the
// measured points by centroid, scale (ratio of the spreads) and the rotation given by azimuth and
// upright. Which azimuth fits best is scored against all views (world_hypotheses.h), not by the
// point-to-point error in this one.
#pragma once

#include <vector>

#include "deepslam/geometry/similarity.h"
#include "deepslam/registration/measured_view.h"
#include "deepslam/registration/visible_surface.h"

namespace deepslam::registration {

// camera_from_object for each azimuth and elevation of the virtual view. The paper's virtual camera
// is level; the second elevation is the real camera's, since a camera at eye height sees the tops
// of furniture. Empty when the view has under three points or no spread.
[[nodiscard]] std::vector<Similarity3> AlignByMoments(VisibleSurface& visible,
                                                      const MeasuredView& view,
                                                      int num_azimuths,
                                                      double min_scale_m,
                                                      double max_scale_m);

}  // namespace deepslam::registration
