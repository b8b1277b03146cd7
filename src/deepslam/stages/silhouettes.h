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
  std::vector<double> ious;  // one per view that shows any of it, ascending frames
  double median_iou = 0;     // 0 without views
};

struct SilhouetteReport {
  std::vector<ObjectSilhouette> objects;  // of the map, in its order
  int num_views = 0;
  double median_iou = 0;         // over all views of all objects; 0 without any
  double lowest_object_iou = 0;  // the lowest median of an object
};

// Projects every mesh of stage `mesh` into the views of its object, at the poses of stage
// `optimize`, and compares it with the usable segments there. Pixels that something nearer hides
// or where nothing was measured are left out. InvalidInput when the workspace lacks a stage or does
// not fit the capture.
[[nodiscard]] Result<SilhouetteReport> EvaluateSilhouettes(const std::filesystem::path& workspace,
                                                           const FrameSource& frames,
                                                           Progress& progress);

}  // namespace deepslam::stages
