// Where the measurement of an object ends.
#pragma once

#include <span>

#include "deepslam/geometry/similarity.h"
#include "deepslam/refine/complete.h"
#include "deepslam/scene/object_view.h"

namespace deepslam::modelling {

// Sides and top of the box round all that the views measured of an object, outliers left out,
// parallel to the sides of its model (world: that of the views). With a support plane the top is
// its level face, where one was seen. No planes where the views hold too few points.
[[nodiscard]] refine::Limits MeasuredLimits(const Similarity3& world_from_object,
                                            std::span<const ObjectView> views,
                                            bool has_support_plane);

}  // namespace deepslam::modelling
