// Things that rest on furniture or hang on a wall.
#pragma once

#include <span>

#include "deepslam/scene/object_class.h"
#include "deepslam/scene/object_view.h"

namespace deepslam::observe {

// For whoever proposes, registers and scores shapes an object rests on the ground of its views.
// Where one of this class rests on something else (its foot, the lowest of what all its views
// measured of it, lies further than a hand above the floor, or the class stands on no floor), the
// ground of the views becomes the level plane through its foot. Views without a ground, and an
// object of which no view measured anything, stay as they are. One object's views.
void PutOnOwnSupport(const Supports& supports, std::span<ObjectView> views);

}  // namespace deepslam::observe
