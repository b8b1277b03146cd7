// What the views of an object say together.
#pragma once

#include <span>

#include "deepslam/propose/shape_prior.h"

namespace deepslam::propose {

// Latents at the least sum of distances to those of the views (geometric median, by Weiszfeld
// 1937): of two views their mean, of more a mean in which a view that was misread weighs little.
// The confidence is the mean of theirs; azimuth and elevation, which differ from view to view, stay
// 0. At least one view.
[[nodiscard]] PriorEncoding JoinEncodings(std::span<const PriorEncoding> views);

}  // namespace deepslam::propose
