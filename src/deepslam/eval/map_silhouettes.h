// How well the objects of a finished map cover what was segmented, where no truth is known.
#pragma once

#include <string>
#include <vector>

#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/optimized_map.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::eval {

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

struct SegmentedMap {
  const OptimizedMap& map;
  const std::vector<TriangleMesh>& meshes;  // of each object of the map, metric object frame
  const Association& association;           // after merging
  const std::vector<Segment>& segments;     // of the frames' size
};

// Projects every mesh into the views of its object and compares it with the usable segments there.
// Pixels that something nearer hides are left out. So are, but for `all_px`, those where nothing
// was measured: no segment can hold them, be it that the sensor fails there or that its image ends
// there. A frame that cannot be read is warned about. Interrupted when the user asks to stop.
[[nodiscard]] Result<SilhouetteReport> CompareSilhouettes(const SegmentedMap& mapped,
                                                          const FrameSource& frames,
                                                          Progress& progress);

}  // namespace deepslam::eval
