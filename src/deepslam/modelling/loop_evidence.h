// What the views of objects measured of them and around them, for verifying loops.
#pragma once

#include <set>
#include <span>

#include "deepslam/core/result.h"
#include "deepslam/loop/constellation.h"
#include "deepslam/modelling/loop_world.h"
#include "deepslam/scene/object_view.h"

namespace deepslam::modelling {

// Adds points that the views measured of the object and around it.
void AppendMeasured(std::span<const ObjectView> views, loop::ObjectEvidence& evidence);

// Of these objects of the map, with the surfaces of their chosen models where they stand.
[[nodiscard]] Result<loop::LoopEvidence> CollectEvidence(const std::set<ObjectId>& wanted,
                                                         const LoopClosing& closing,
                                                         const LoopWorld& world);

}  // namespace deepslam::modelling
