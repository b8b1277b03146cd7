// The ground as a person says it lies.
#pragma once

#include <string>
#include <vector>

#include "deepslam/scene/ground.h"
#include "deepslam/scene/overrides.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::overrides {

// Ground that agrees with the hint (10 degrees, 0.15 m) stays; all other is left out, and the hint
// stands in for it. One sentence where a hint was applied.
[[nodiscard]] std::vector<std::string> ApplyToGround(const Overrides& overrides,
                                                     const Trajectory& trajectory,
                                                     Ground& ground);

}  // namespace deepslam::overrides
