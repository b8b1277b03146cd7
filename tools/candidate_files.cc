#include "candidate_files.h"

#include "deepslam/artifact/proposals_json.h"
#include "deepslam/artifact/registrations_json.h"
#include "deepslam/artifact/store.h"
#include "deepslam/stages/stage_inputs.h"
#include "eval_data.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;

Status AddCandidates(const fs::path& file, CandidateFiles& files) {
  const Result<std::string> text = artifact::ReadFile(file);
  if (!text.ok()) return text.error();
  const Result<Proposals> proposals = artifact::DecodeProposals(*text, file.string());
  if (!proposals.ok()) return proposals.error();
  for (const ShapeCandidate& candidate : proposals->candidates)
    files.candidates.emplace(candidate.id, candidate);
  return Ok();
}

Status AddRegistrations(const fs::path& file, CandidateFiles& files) {
  const Result<std::string> text = artifact::ReadFile(file);
  if (!text.ok()) return text.error();
  const auto registrations = artifact::DecodeRegistrations(*text, file.string());
  if (!registrations.ok()) return registrations.error();
  for (const CandidateRegistration& registration : *registrations)
    files.registrations.emplace(registration.candidate, registration);
  return Ok();
}

}  // namespace

Result<CandidateFiles> ReadCandidateFiles(const fs::path& workspace) {
  CandidateFiles files;
  for (const char* stage : {"propose", "select"}) {
    if (Status status = AddCandidates(workspace / stage / "candidates.json", files); !status.ok())
      return status.error();
  }
  for (const char* stage : {"register", "select"}) {
    if (Status status = AddRegistrations(workspace / stage / "registrations.json", files);
        !status.ok())
      return status.error();
  }
  return files;
}

Result<VoxelGrid> ReadCandidateModel(const fs::path& workspace, const ShapeCandidate& candidate) {
  return ReadGrid(workspace / stages::StageOfModel(candidate.source) / "models" /
                  (candidate.model + ".binvox"));
}

}  // namespace deepslam::tools
