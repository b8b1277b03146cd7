// Gaps of a segment where the sensor measured nothing: dark legs, shiny frames, shadows between
// slats. They belong to the object's outline though no point lies there.
#pragma once

#include "deepslam/core/image.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/segment/region.h"

namespace deepslam::segment {

// Adds to `mask` the pixels of `region` without depth that lie between two pixels of the mask, in
// their row or in their column, with nothing measured in between and at most `gap_m` apart at the
// nearer one's depth. Pixels with depth are left as they are, so a filled gap never covers what was
// measured behind it. `taken` are pixels that earlier segments filled; this one's are added to it.
void FillUnmeasured(const DepthImage& depth_m,
                    const PinholeCamera& camera,
                    const Region& region,
                    double gap_m,
                    Mask& taken,
                    Mask& mask);

}  // namespace deepslam::segment
