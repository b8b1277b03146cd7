// Second thoughts once all frames are matched: duplicates, parts of others, and noise.
#pragma once

#include <vector>

#include "deepslam/associate/associate.h"
#include "deepslam/associate/coarse_views.h"
#include "deepslam/associate/object_hypothesis.h"
#include "deepslam/geometry/camera.h"

namespace deepslam::associate {

// Merges objects that fill the same space, into the lower id; where both were seen in a frame the
// better detection stays. What was never seen side by side may be apart by drift; a box within the
// other is no side. An object of another class that lies inside a larger, better seen one is
// dissolved. Rejections are appended.
void MergeDuplicates(std::vector<ObjectHypothesis>& objects,
                     std::vector<Observation>& all,
                     std::vector<Rejection>& rejections);

// Removes objects that were detected too seldom for how often they were in view.
void RejectNoise(std::vector<ObjectHypothesis>& objects,
                 std::vector<Observation>& all,
                 const CoarseViews& views,
                 const PinholeCamera& camera,
                 const AssociateOptions& options,
                 std::vector<Rejection>& rejections);

}  // namespace deepslam::associate
