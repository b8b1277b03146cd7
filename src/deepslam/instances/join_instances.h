// Parts of one thing that no view saw together and whose surfaces nothing joins, told by their
// places: no thing is found twice.
#pragma once

#include <span>
#include <vector>

#include "deepslam/instances/find_instances.h"

namespace deepslam::instances {

// Of each instance the position of the one that it is a part of, no greater than its own; its own
// where it is no other's part. Parts of one thing are instances of one class, or such that nothing
// names, since their classes are guesses by size,
//  - whose boxes share more than half of the smaller one;
//  - that detections name and one of which lies over the other, as the back of a chair on its seat;
//  - that nothing names, begin and end alike, overlap and fill one outline between them, as the
//    ends of a cabinet do;
//  - that nothing names and that stand one above the other on the same outline, as the boards of a
//    rack do.
// Instances that are rejected are nobody's part, but for such boards, each of which may be too
// little to be a thing, and for legs: what is slim, stands under a support plane and reaches up to
// it carries it, whatever its size and its name.
[[nodiscard]] std::vector<int> WholesOf(std::span<const Instance> instances);

// Of each instance the position of the thing that it carries as its foot; -1: of none. A foot is
// what nothing names, stands on the floor and ends below a named thing, within its outline, where
// things of that class stand on floors and this one would float: the pedestal of a washbasin, the
// base of a chair. What lies under a support plane is no foot of it, nor is furniture that a plant
// or a lamp stands on; but what detections call a vase is the pot of the plant in it, also where
// the plant has a part of it already. A seat that nothing names is carried by no one's foot, but
// goes with the back of a chair that detections name, however little was seen of that.
[[nodiscard]] std::vector<int> CarriedByFeet(std::span<const Instance> instances,
                                             const ClassTable& classes);

// Of each instance the position of the thing that it is the rest of; -1: of none. A rest is shorter
// than any thing of its class, which is closed, as sofas and beds are, and stands within 0.3 m of a
// whole one with which it is no larger than they may be.
[[nodiscard]] std::vector<int> RestsOf(std::span<const Instance> instances,
                                       const ClassTable& classes);

}  // namespace deepslam::instances
