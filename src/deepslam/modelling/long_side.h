// Which side of a table is its front.
#pragma once

#include "deepslam/refine/complete.h"

namespace deepslam::modelling {

// A support plane has no front that its shape tells. As with the models of catalogues x crosses its
// longer side: where the model is longer along x by more than a tenth, its axes are turned by a
// quarter about the vertical, the shape staying where it is.
void FaceAcrossLongSide(refine::CompletedModel& model);

}  // namespace deepslam::modelling
