// Closed doors in a wall's face, by their casings.
#pragma once

#include <vector>

#include "deepslam/layout/wall_openings.h"
#include "deepslam/layout/wall_profile.h"

namespace deepslam::layout {

// Doors as wide and high as doors of homes are, around which a strip of the face stands out on both
// sides and above, against the wall outside it and against the leaf inside: the casing (architrave)
// that covers the joint between frame and wall. By position, none over another.
[[nodiscard]] std::vector<FaceOpening> FindCasings(const WallProfile& profile,
                                                   const WallFace& face);

}  // namespace deepslam::layout
