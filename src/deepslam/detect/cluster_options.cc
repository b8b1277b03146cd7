#include "deepslam/detect/cluster_detector.h"

namespace deepslam::detect {

void Describe(OptionsVisitor& visitor, ClusterOptions& options) {
  visitor.Field("enabled", options.enabled, "look for floor-standing clusters no detection covers");
}

}  // namespace deepslam::detect
