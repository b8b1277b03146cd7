// The room of a scene as a layout: its walls, openings, floor and ceiling as they are.
#pragma once

#include "deepslam/scene/layout.h"
#include "deepslam/synth/scene_description.h"

namespace deepslam::synth {

// In the scene's world. Gaps that reach the floor are doors up to the width of two wings
// (scene/layout.h) and passages beyond; others are windows.
[[nodiscard]] Layout TrueLayout(const SceneDescription& description);

}  // namespace deepslam::synth
