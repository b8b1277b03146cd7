// Writes the floor plan of two rooms as DXF, for plan_dxf_reader_test.py:  write_plan FILE
#include <fstream>
#include <iostream>

#include "deepslam/report/plan_dxf.h"
#include "support/layout_samples.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: write_plan FILE\n";
    return 2;
  }
  deepslam::report::FloorPlanContent content;
  content.title = "two rooms";
  content.layout_world = deepslam::testing_support::TwoRoomLayout();
  content.layout_world.walls[3].from_m = {0, 1.5};  // the rest of the side was not seen
  content.things = {deepslam::report::MakePlanThing("table_02",
                                                    {Eigen::Quaterniond::Identity(), {2, 1.5, 0.4}},
                                                    {0.8, 1.6, 0.75},
                                                    {10, 200, 30})};
  std::ofstream out(argv[1], std::ios::binary);
  out << deepslam::report::FloorPlanDxf(content);
  return out.good() ? 0 : 1;
}
