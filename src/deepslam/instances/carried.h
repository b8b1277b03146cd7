// Things on other things that nothing names: boxes, books and screens on a counter.
#pragma once

#include <span>

#include "deepslam/instances/find_instances.h"

namespace deepslam::instances {

// Rejects every instance that no detection names and that stands on something: on another instance,
// which is not rejected and has the larger box, where it begins as that one ends and most of its
// outline lies over it; or on a counter of which too little was seen to tell, where it is no longer
// than a metre and begins at the height of tops. What hangs higher, as wall cabinets do, stays.
void RejectCarried(std::span<Instance> instances);

}  // namespace deepslam::instances
