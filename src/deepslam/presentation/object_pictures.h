// Pictures and points of one object: its model drawn into crops, models by themselves, its measured
// depth.
#pragma once

#include <cstddef>
#include <set>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "deepslam/frames/frame_source.h"
#include "deepslam/presentation/pictured_object.h"
#include "deepslam/report/report_content.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/optimized_map.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::presentation {

// How much of each object is shown, so that the page of a hall is no larger than a browser likes.
struct PictureLimits {
  int crops = 4;
  int thumbnails = 12;
  int points_per_view = 1200;
};
[[nodiscard]] PictureLimits LimitsFor(std::size_t num_objects);

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

}  // namespace deepslam::presentation
