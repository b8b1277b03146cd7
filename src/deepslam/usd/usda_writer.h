// A scene as text of Universal Scene Description (.usda), for what reads OpenUSD 22.11 or later.
//
// Metres, z up, default prim `/World`. Below it a group each (`/World/Objects/chair_03`), with one
// Xform per prim: its pose, the label by `SemanticsLabelsAPI:class` and by the attributes that
// Isaac Sim read before there was such a schema, custom data `deepslam`, attributes
// `userProperties` for Blender, and a Mesh of the same name whose vertex colours are the primvar
// displayColor and, through a primvar reader, the diffuse colour of a UsdPreviewSurface.
#pragma once

#include <string>

#include "deepslam/core/result.h"
#include "deepslam/usd/usd_scene.h"

namespace deepslam::usd {

// Same scene, same bytes; an empty scene is a valid file. Coordinates are rounded to 0.01 mm.
// Errors (kInvalidInput), each with the prim's name: indices out of range, coordinates or a pose
// that are not finite.
[[nodiscard]] Result<std::string> WriteUsda(const UsdScene& scene);

}  // namespace deepslam::usd
