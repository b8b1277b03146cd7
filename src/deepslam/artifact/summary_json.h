// optimize/summary.json: how the graph was solved, and the ground of the final world.
#pragma once

#include <string>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"
#include "deepslam/scene/optimized_map.h"

namespace deepslam::artifact {

struct OptimizationRecord {
  OptimizationSummary summary;
  Plane ground_world;
  bool has_ground = false;
};

[[nodiscard]] Result<std::string> EncodeOptimization(const OptimizationRecord& record,
                                                     std::string_view name);
[[nodiscard]] Result<OptimizationRecord> DecodeOptimization(TextSource text, std::string_view name);

}  // namespace deepslam::artifact
