// Boxes from depth alone: connected clusters that stand on the floor and that no detection covers.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "deepslam/core/options.h"
#include "deepslam/frames/frame.h"
#include "deepslam/geometry/box.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/plane.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/object_class.h"

namespace deepslam::detect {

struct ClusterOptions {
  bool enabled = true;
  // Points lower than this above the ground belong to the ground.
  static constexpr double kMinHeight_m = 0.10;
  // Points above belong to the room; a cluster that reaches it is none.
  static constexpr double kMaxHeight_m = 2.0;
  static constexpr double kMaxDepth_m = 4.0;  // farther depth is too coarse to tell clusters apart
  // Clusters that begin higher hang on a wall or lie on something.
  static constexpr double kMaxBase_m = 0.25;
  // Grid on the ground in which clusters are connected: two to three pixels of a reduced frame at
  // 4 m.
  static constexpr double kCell_m = 0.04;
  // Clusters that cover less ground are no furniture: 20 cm square.
  static constexpr double kMinFootprint_m2 = 0.04;
  // Longest side of the cluster: smaller things are not mapped (select_options.h).
  static constexpr double kMinSize_m = 0.30;
  static constexpr double kMaxSize_m = 2.2;  // longer ones are walls, or several things in one
  // Share of the image's pixels: 300 of a reduced frame of 320 x 240.
  static constexpr double kMinPointsShare = 0.004;
  // A cluster whose pixels are covered more than this by the detection that found it is its own.
  static constexpr double kMaxCoveredShare = 0.35;
  // Floor must be seen around this much of the cluster's visible foot ...
  static constexpr double kFreeMargin_m = 0.15;
  // ... along this share of its outline: it stands free and is no part of a wall.
  static constexpr double kMinFreeShare = 0.5;
};
void Describe(OptionsVisitor& visitor, ClusterOptions& options);

// The clusters of one frame before anybody says what detections of other sources cover.
struct FrameClusters {
  struct Furniture {
    Detection detection;      // source kCluster, mask set, id invalid
    std::size_t cluster = 0;  // of `boxes_px`
  };
  std::vector<Furniture> furniture;  // largest first
  std::vector<Box2> boxes_px;        // of all clusters, furniture or not, largest first
};

// The class is the one of the table whose sizes fit best among those without detector labels
// (cabinet, shelf ...), else `furniture`; nothing at all where the table has neither.
// `ground_camera`: normal up, d the camera's height. The frame's colour may be empty.
[[nodiscard]] FrameClusters FindClusters(const Frame& frame,
                                         const PinholeCamera& camera,
                                         const Plane& ground_camera,
                                         const ClassTable& classes,
                                         const ClusterOptions& options);

// The furniture that none of `covered` has found or covers.
[[nodiscard]] std::vector<Detection> Uncovered(FrameClusters clusters,
                                               std::span<const Detection> covered);

// Both at once.
[[nodiscard]] std::vector<Detection> DetectClusters(const Frame& frame,
                                                    const PinholeCamera& camera,
                                                    const Plane& ground_camera,
                                                    std::span<const Detection> covered,
                                                    const ClassTable& classes,
                                                    const ClusterOptions& options);

}  // namespace deepslam::detect
