// Objects that loops found to be one.
#pragma once

#include "deepslam/core/result.h"
#include "deepslam/modelling/loop_world.h"
#include "deepslam/scene/loop.h"

namespace deepslam::modelling {

// The kept object of every merge gets members, views and candidates of what was merged into it, and
// is scored anew with everything that was seen of it, views moved by the corrections of the
// constellations that say so. Of two classes the one that was seen more often stays.
[[nodiscard]] Status MergeObjects(const Loops& found, const LoopClosing& closing, LoopWorld& world);

}  // namespace deepslam::modelling
