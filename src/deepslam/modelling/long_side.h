// Which side of a table is its front.
#pragma once

#include <span>

#include "deepslam/geometry/plane.h"
#include "deepslam/refine/complete.h"

namespace deepslam::modelling {

// A support plane has no front that its shape tells. As with the models of catalogues x crosses its
// longer side: where the model is longer along x by more than a tenth, its axes are turned by a
// quarter about the vertical, x away from the nearest of `walls` (Limits, of the completed model's
// frame), the shape staying where it is.
void FaceAcrossLongSide(std::span<const Plane> walls, refine::CompletedModel& model);

}  // namespace deepslam::modelling
