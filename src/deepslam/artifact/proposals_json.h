// candidates.json: every shape candidate of every object. The voxel models lie beside it as
// models/<key>.binvox (shape/binvox.h); this codec lists their keys.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"
#include "deepslam/scene/shape_candidate.h"

namespace deepslam::artifact {

// The models themselves are not written.
[[nodiscard]] Result<std::string> EncodeProposals(const Proposals& proposals,
                                                  std::string_view name);
// `models` of the result has every key, with a grid without any voxels, not even empty ones: the
// grids of hundreds of models would be the largest of what a stage holds. Keys are plain file
// stems: letters, digits, '_', '-', '.' not in front; others are refused, since they become paths.
[[nodiscard]] Result<Proposals> DecodeProposals(TextSource text, std::string_view name);

[[nodiscard]] bool IsModelKey(std::string_view key);

}  // namespace deepslam::artifact
