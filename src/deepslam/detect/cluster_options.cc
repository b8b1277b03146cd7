#include "deepslam/detect/cluster_detector.h"

namespace deepslam::detect {

void Describe(OptionsVisitor& visitor, ClusterOptions& options) {
  visitor.Field("enabled", options.enabled, "look for floor-standing clusters no detection covers");
  visitor.Field(
      "min_height_m", options.min_height_m, {0.02, 1}, "m", "lower points belong to the ground");
  visitor.Field("max_height_m",
                options.max_height_m,
                {0.3, 5},
                "m",
                "clusters that reach higher belong to the room");
  visitor.Field("max_depth_m", options.max_depth_m, {0.5, 20}, "m", "farther depth is not used");
  visitor.Field("max_base_m",
                options.max_base_m,
                {0.02, 1},
                "m",
                "a cluster's lowest point must be this near to the ground");
  visitor.Field("cell_m",
                options.cell_m,
                {0.01, 0.2},
                "m",
                "cell of the grid on the ground in which clusters are connected");
  visitor.Field("min_footprint_m2",
                options.min_footprint_m2,
                {0, 5},
                "m2",
                "clusters that cover less ground are dropped");
  visitor.Field(
      "min_size_m", options.min_size_m, {0.05, 5}, "m", "least longest side of a cluster");
  visitor.Field("max_size_m",
                options.max_size_m,
                {0.3, 10},
                "m",
                "wider clusters are walls or fitted furniture");
  visitor.Field("min_points_share",
                options.min_points_share,
                {0, 1},
                "1",
                "least share of the image's pixels");
  visitor.Field("max_covered_share",
                options.max_covered_share,
                {0, 1},
                "1",
                "clusters covered more than this by the detection that found them are dropped");
  visitor.Field("free_margin_m",
                options.free_margin_m,
                {0.02, 1},
                "m",
                "floor must be seen within this distance of the cluster's foot");
  visitor.Field("min_free_share",
                options.min_free_share,
                {0, 1},
                "1",
                "share of the outline along which floor must be seen");
}

}  // namespace deepslam::detect
