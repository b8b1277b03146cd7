// The height of a support plane among all that was taken for the thing.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "deepslam/instances/surface_elements.h"

namespace deepslam::instances {

// Heights of those of the elements `own` that face up, ascending.
[[nodiscard]] std::vector<double> HeightsFacingUp(std::span<const int> own,
                                                  const SurfaceElements& elements);

// The height at which most of the elements `own` that face up lie, or the highest of several that
// hold half as many: a top and boards under it. None where no height holds enough for a top.
[[nodiscard]] std::optional<double> SupportHeight(std::span<const int> own,
                                                  const SurfaceElements& elements);

}  // namespace deepslam::instances
