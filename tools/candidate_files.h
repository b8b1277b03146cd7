// All candidates of a workspace and where they stand, in the tracking world: what stage propose
// offered, what stage select refined of it, and what stage loops scored anew.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "deepslam/core/ids.h"
#include "deepslam/core/result.h"
#include "deepslam/scene/registration.h"
#include "deepslam/scene/shape_candidate.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::tools {

struct CandidateFiles {
  std::map<CandidateId, ShapeCandidate> candidates;
  std::map<CandidateId, CandidateRegistration> registrations;
  std::map<CandidateId, std::string> stages;  // that keep the candidates' models
};

[[nodiscard]] Result<CandidateFiles> ReadCandidateFiles(const std::filesystem::path& workspace);

// The model of one of its candidates.
[[nodiscard]] Result<VoxelGrid> ReadCandidateModel(const std::filesystem::path& workspace,
                                                   const CandidateFiles& files,
                                                   const ShapeCandidate& candidate);

}  // namespace deepslam::tools
