// What RTAB-Map's databases keep of a node's camera.
#include <cmath>

#include "deepslam/formats/rtabmap_database.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(rtabmap_calibration) {
  const auto camera = formats::ParseNodeCamera(bytes);
  if (!camera.ok()) {
    DEEPSLAM_CHECK(!camera.error().message.empty(), "a refusal says why");
    return false;
  }
  DEEPSLAM_CHECK(camera->base_from_camera.translation_m.allFinite(), "a place is finite");
  DEEPSLAM_CHECK(std::abs(camera->base_from_camera.rotation.norm() - 1) < 1e-6,
                 "a rotation is one");
  return true;
}
