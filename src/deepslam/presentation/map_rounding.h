// What the compact map's numbers are rounded to when it is written; a scene that is made of it
// gives poses back to half of it.
#pragma once

#include "deepslam/scene/compact_map.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::presentation {

inline constexpr double kMapPlaceStepM = 1e-4;    // translations
inline constexpr double kMapOutlineStepM = 1e-2;  // corners of the ground's outline
inline constexpr double kMapLayoutStepM = 1e-3;   // places and heights of the layout
inline constexpr double kMapShareStep = 1e-2;     // its shares and confidences
inline constexpr double kMapRotationStep = 1e-7;  // components of unit quaternions
inline constexpr double kMapScaleStepM = 1e-6;    // metres per object unit
inline constexpr double kMapScoreStep = 1e-4;     // confidence

// The ground with its corners rounded to kMapOutlineStepM, or to kMapPlaceStepM where that would
// make its outline cross itself: scene and map then hold the very same one.
[[nodiscard]] TriangleMesh RoundedGround(const TriangleMesh& ground_polygon);

// The numbers of a map rounded so; the outline of the ground to kMapPlaceStepM (see RoundedGround).
// Rotations stay unit quaternions within what readers accept.
[[nodiscard]] CompactMap Rounded(CompactMap map);

}  // namespace deepslam::presentation
