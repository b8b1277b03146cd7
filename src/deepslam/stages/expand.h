// The scene again from the compact map alone.
#pragma once

#include "deepslam/core/result.h"
#include "deepslam/gltf/scene_writer.h"
#include "deepslam/scene/compact_map.h"
#include "deepslam/scene/model_library.h"

namespace deepslam::stages {

// What the map's numbers are rounded to when it is written; `expand` gives poses back to half of
// it.
inline constexpr double kMapPlaceStepM = 1e-4;    // translations
inline constexpr double kMapOutlineStepM = 1e-2;  // corners of the ground's outline
inline constexpr double kMapRotationStep = 1e-7;  // components of unit quaternions
inline constexpr double kMapScaleStepM = 1e-6;    // metres per object unit
inline constexpr double kMapScoreStep = 1e-4;     // confidence

// The ground with its corners rounded to kMapOutlineStepM, or to kMapPlaceStepM where that would
// make its outline cross itself: scene and map then hold the very same one.
[[nodiscard]] TriangleMesh RoundedGround(const TriangleMesh& ground_polygon);

// The numbers of a map rounded so; the outline of the ground to kMapPlaceStepM (see RoundedGround).
// Rotations stay unit quaternions within what readers accept.
[[nodiscard]] CompactMap Rounded(CompactMap map);

// Whether any object of the map needs the library.
[[nodiscard]] bool NeedsLibrary(const CompactMap& map);

// Objects with ids, names, classes, poses, shapes and class colours, and the ground. `library` may
// be null when no object needs it. Errors (kInvalidInput), each naming the object: its model is not
// in the library or is another there; its shape is a network's and no decoder is installed; its
// voxels are damaged; a mesh option is unknown.
[[nodiscard]] Result<gltf::GltfScene> ExpandMap(const CompactMap& map, const ModelLibrary* library);

}  // namespace deepslam::stages
