#include "deepslam/presentation/map_plan.h"

#include <cstddef>

#include "deepslam/geometry/box.h"

namespace deepslam::presentation {

report::FloorPlanContent PlanOf(const FinishedMap& finished,
                                const ClassTable& classes,
                                const std::string& title) {
  report::FloorPlanContent plan;
  plan.title = title;
  plan.layout_world = finished.layout_world;
  for (std::size_t n = 0; n < finished.meshes.size(); ++n) {
    if (finished.meshes[n].empty()) continue;
    const MapObject& object = finished.map.map.objects[n];
    Box3 box;
    for (const Eigen::Vector3f& vertex : finished.meshes[n].vertices)
      box.Extend(vertex.cast<double>());
    plan.things.push_back(report::MakePlanThing(ObjectName(object),
                                                object.world_from_object,
                                                box.Size(),
                                                ClassColour(classes, object.class_name)));
  }
  return plan;
}

}  // namespace deepslam::presentation
