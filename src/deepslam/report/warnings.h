// What the page warns of.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "deepslam/scene/object_map.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/shape_candidate.h"

namespace deepslam::report {

// Sentences: those of the capture, what sources of shapes and the map left out, what was
// seen and is no object, and how many
// detections belong to no object, for each reason.
[[nodiscard]] std::vector<std::string> Warnings(std::span<const std::string> capture_warnings,
                                                const Association& association,
                                                const Proposals& proposals,
                                                const ObjectMap& map);

}  // namespace deepslam::report
