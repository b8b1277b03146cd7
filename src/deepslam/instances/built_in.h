// What is built into furniture, as a sink into a row of kitchen cabinets: the piece of furniture
// under it is one thing with it, and what stands on either side are pieces of their own.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "deepslam/instances/find_instances.h"
#include "deepslam/instances/surface_elements.h"
#include "deepslam/scene/object_class.h"

namespace deepslam::instances {

// How a thing that no detection names is cut where another one is built in. Elements ascending.
struct BuiltInCut {
  std::size_t host = 0;                  // index of the instance that is cut
  std::vector<int> under;                // its elements that become the built-in thing's
  std::vector<std::vector<int>> beside;  // the rest of it, on either side
};

// The first thing that the instance `built_in` is built into: nothing where its class is never
// built in, or where no unnamed thing stands under it.
[[nodiscard]] std::optional<BuiltInCut> CutUnder(std::size_t built_in,
                                                 std::span<const Instance> instances,
                                                 const SurfaceElements& elements,
                                                 const ClassTable& classes);

}  // namespace deepslam::instances
