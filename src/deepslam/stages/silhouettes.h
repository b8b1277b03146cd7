// How well the finished map's objects cover what was segmented, where no truth is known.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/scene/frame_source.h"

namespace deepslam::stages {

struct ObjectSilhouette {
  std::string name;  // "chair_03"
  std::string class_name;
  // One per view that shows any of it, ascending frames: over the pixels that were measured, and
  // over all.
  std::vector<double> ious;
  std::vector<double> ious_all_px;
  double median_iou = 0;  // 0 without views
  double median_iou_all_px = 0;
};

struct SilhouetteReport {
  std::vector<ObjectSilhouette> objects;  // of the map, in its order
  int num_views = 0;
  double median_iou = 0;  // over all views of all objects; 0 without any
  double median_iou_all_px = 0;
  double lowest_object_iou = 0;  // the lowest median of an object
};

// Projects every mesh of stage `mesh` into the views of its object, at the poses of stage
// `optimize`, and compares it with the usable segments there. Pixels that something nearer
// hides are left out. So are, but for `all_px`, those where nothing was measured: no segment can
// hold them, be it that the sensor fails there or that its image ends there. InvalidInput when the
// workspace lacks a stage or does not fit the capture.
[[nodiscard]] Result<SilhouetteReport> EvaluateSilhouettes(const std::filesystem::path& workspace,
                                                           const FrameSource& frames,
                                                           Progress& progress);

}  // namespace deepslam::stages
