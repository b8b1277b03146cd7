// All candidates of a workspace and where they stand: what stage propose offered and what stage
// select refined of it.
#pragma once

#include <filesystem>
#include <map>

#include "deepslam/core/ids.h"
#include "deepslam/core/result.h"
#include "deepslam/scene/registration.h"
#include "deepslam/scene/shape_candidate.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::tools {

struct CandidateFiles {
  std::map<CandidateId, ShapeCandidate> candidates;
  std::map<CandidateId, CandidateRegistration> registrations;
};

[[nodiscard]] Result<CandidateFiles> ReadCandidateFiles(const std::filesystem::path& workspace);

[[nodiscard]] Result<VoxelGrid> ReadCandidateModel(const std::filesystem::path& workspace,
                                                   const ShapeCandidate& candidate);

}  // namespace deepslam::tools
