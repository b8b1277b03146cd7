// Pictures of the report page, drawn from values: the map rendered, models drawn into crops, frames
// with detections.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/report/report_content.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/frame_source.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/optimized_map.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::stages {

// An object as the pictures need it.
struct PicturedObject {
  const MapObject* object = nullptr;
  std::string name;
  TriangleMesh mesh;  // object frame, metres
  Rgb8 colour;
};

// The map from two sides, and from where frames that see most of it were taken, the photograph
// beside.
[[nodiscard]] std::vector<report::Picture> ScenePictures(std::span<const PicturedObject> objects,
                                                         const TriangleMesh& room_world,
                                                         const OptimizedMap& map,
                                                         const FrameSource& frames);

// Crops of up to four views of one object with the outline of its model at its final pose.
[[nodiscard]] std::vector<report::Picture> ObjectPictures(const PicturedObject& object,
                                                          std::span<const Segment> segments,
                                                          const OptimizedMap& map,
                                                          const FrameSource& frames);

// Up to six keyframes over the capture with detections and segments; those of one object share a
// colour.
[[nodiscard]] std::vector<report::Picture> FramePictures(std::span<const Segment> segments,
                                                         std::span<const ObjectTrack> tracks,
                                                         const OptimizedMap& map,
                                                         const FrameSource& frames);

}  // namespace deepslam::stages
