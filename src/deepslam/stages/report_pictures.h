// Pictures of the report page, drawn from values: the map rendered, models drawn into crops, frames
// with detections.
#pragma once

#include <cstddef>
#include <set>
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
#include "deepslam/shape/shape_model.h"

namespace deepslam::stages {

// An object as the pictures need it.
struct PicturedObject {
  const MapObject* object = nullptr;
  std::string name;
  TriangleMesh mesh;  // object frame, metres
  Rgb8 colour;
};

// How much of each object is shown, so that the page of a hall is no larger than a browser likes.
struct PictureLimits {
  int crops = 4;
  int thumbnails = 12;
  int points_per_view = 1200;
};
[[nodiscard]] PictureLimits LimitsFor(std::size_t num_objects);

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

// Crops of some views of one object with the outline of its model at its final pose.
[[nodiscard]] std::vector<report::Picture> ObjectPictures(const PicturedObject& object,
                                                          std::span<const Segment> segments,
                                                          const OptimizedMap& map,
                                                          const FrameSource& frames,
                                                          const std::set<FrameIdx>& shown,
                                                          int max_pictures);

// Depth pixels of the object's segments in some of its views, in the world, m.
[[nodiscard]] std::vector<Eigen::Vector3f> MeasuredPoints(const MapObject& object,
                                                          std::span<const Segment> segments,
                                                          const OptimizedMap& map,
                                                          const FrameSource& frames,
                                                          int max_points_per_view);

// A model by itself, seen from front left above, on white. No bytes when it is empty.
[[nodiscard]] report::Picture Thumbnail(const shape::ShapeModel& model, Rgb8 colour);

// Up to six keyframes of `shown` with segments, evenly among them.
[[nodiscard]] std::vector<FrameIdx> FramesToPicture(std::span<const Segment> segments,
                                                    const OptimizedMap& map,
                                                    const std::set<FrameIdx>& shown);
// These frames with their segments; those of one object share a colour.
[[nodiscard]] std::vector<report::Picture> FramePictures(std::span<const FrameIdx> wanted,
                                                         std::span<const Segment> segments,
                                                         std::span<const ObjectTrack> tracks,
                                                         const OptimizedMap& map,
                                                         const FrameSource& frames);

}  // namespace deepslam::stages
