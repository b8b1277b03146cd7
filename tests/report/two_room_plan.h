// A plan to draw: two rooms (support/layout_samples.h) and a table, under a title that has to be
// escaped.
#pragma once

#include "deepslam/report/floor_plan.h"
#include "support/layout_samples.h"

namespace deepslam::report {

inline FloorPlanContent TwoRoomPlan() {
  FloorPlanContent content;
  content.title = "home <1>";
  content.layout_world = testing_support::TwoRoomLayout();
  content.things = {MakePlanThing("table_02",
                                  {Eigen::Quaterniond::Identity(), {2, 1.5, 0.4}},
                                  {0.8, 1.6, 0.75},
                                  {10, 200, 30})};
  return content;
}

}  // namespace deepslam::report
