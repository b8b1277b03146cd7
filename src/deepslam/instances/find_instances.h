// Things of a whole capture: the surface that is not floor, wall or ceiling, divided by its shape
// and by what the detections of all frames say.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "deepslam/core/options.h"
#include "deepslam/instances/merge_superpoints.h"
#include "deepslam/instances/superpoints.h"
#include "deepslam/instances/surface_elements.h"
#include "deepslam/instances/upright_box.h"
#include "deepslam/instances/view_votes.h"
#include "deepslam/scene/layout.h"
#include "deepslam/scene/object_class.h"

namespace deepslam::instances {

struct InstanceOptions {
  SuperpointOptions superpoints;
  VoteOptions votes;
  MergeOptions merge;
  double min_size_m = 0.25;      // two sides of a thing are this long at least
  double min_surface_m2 = 0.04;  // least surface that was seen of it
  // A class that detections name in a smaller share of the views, weighted by their scores, does
  // not name the thing.
  double min_class_share = 0.15;
  // Of things that no detection names:
  double max_base_m = 0.25;   // they stand on the floor when they begin below this ...
  double min_depth_m = 0.15;  // ... and are no thinner; thinner ones are parts of walls and doors
  double min_unnamed_size_m = 0.45;  // smaller ones are household clutter: bags, boxes, devices
  double min_hung_depth_m = 0.2;     // and its shorter side on the ground
  double max_top_m = 2.3;            // higher ones belong to the room
  double max_size_m = 3.5;           // longer ones are no single thing
};
void Describe(OptionsVisitor& visitor, InstanceOptions& options);

struct Instance {
  std::vector<int> elements;  // ascending
  UprightBox box_level;
  // Class of most votes; of a thing that no detection names the class whose sizes hold it.
  std::string class_name;
  bool is_named = false;           // by detections
  bool has_support_plane = false;  // as its class says
  std::optional<double> top_m;     // of a thing with a support plane: its height (support_height.h)
  // Sum of the scores of detections that claimed its superpoints over the views that saw them.
  std::map<std::string, double> class_shares;
  std::string rejection;  // why it is no object of the map; empty: it is one
};

struct Instances {
  std::vector<Instance> instances;  // in the order of their first superpoints
  std::vector<int> of_element;      // of each element: index of its instance; -1: none
};

// `votes` of these superpoints; `walls` of the elements' world.
[[nodiscard]] Instances FindInstances(const SurfaceElements& elements,
                                      const Superpoints& superpoints,
                                      std::span<const ElementPair> pairs,
                                      const ViewVotes& votes,
                                      std::span<const LayoutWall> walls,
                                      const ClassTable& classes,
                                      const InstanceOptions& options);

}  // namespace deepslam::instances
