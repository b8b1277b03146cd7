// Pictures of the whole map, drawn from values.
#pragma once

#include <set>
#include <span>
#include <vector>

#include "deepslam/frames/frame_source.h"
#include "deepslam/presentation/pictured_object.h"
#include "deepslam/report/report_content.h"
#include "deepslam/scene/optimized_map.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::presentation {

// The map from two sides.
[[nodiscard]] std::vector<report::Picture> ScenePictures(std::span<const PicturedObject> objects,
                                                         const OptimizedMap& map);

// A small picture of the map from the camera's side, for lists; without objects, of the room. No
// bytes when there is neither.
[[nodiscard]] report::Picture SceneThumbnail(std::span<const PicturedObject> objects,
                                             const TriangleMesh& room_world,
                                             const OptimizedMap& map);

// Photographs of the keyframes in `shown` that see most of the map, and the map from there.
[[nodiscard]] std::vector<report::PicturePair> Photographs(std::span<const PicturedObject> objects,
                                                           const TriangleMesh& room_world,
                                                           const OptimizedMap& map,
                                                           const FrameSource& frames,
                                                           const std::set<FrameIdx>& shown);

}  // namespace deepslam::presentation
