// A finished map as the floor plan shows it.
#pragma once

#include <string>

#include "deepslam/presentation/finished_map.h"
#include "deepslam/report/floor_plan.h"
#include "deepslam/scene/object_class.h"

namespace deepslam::presentation {

// Objects without a surface are on no plan.
[[nodiscard]] report::FloorPlanContent PlanOf(const FinishedMap& finished,
                                              const ClassTable& classes,
                                              const std::string& title);

}  // namespace deepslam::presentation
