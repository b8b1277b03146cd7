#include "candidate_files.h"

#include <system_error>

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
  Status status = AddCandidates(workspace / "propose" / "candidates.json", files);
  if (status.ok()) status = AddRegistrations(workspace / "register" / "registrations.json", files);
  // Workspaces of before there was refinement have none.
  std::error_code error;
  const bool has_refined = fs::exists(workspace / "select" / "candidates.json", error);
  if (status.ok() && has_refined)
    status = AddCandidates(workspace / "select" / "candidates.json", files);
  if (status.ok() && has_refined)
    status = AddRegistrations(workspace / "select" / "registrations.json", files);
  if (!status.ok()) return status.error();
  return files;
}

Result<VoxelGrid> ReadCandidateModel(const fs::path& workspace, const ShapeCandidate& candidate) {
  return ReadGrid(workspace / stages::StageOfModel(candidate.source) / "models" /
                  (candidate.model + ".binvox"));
}

}  // namespace deepslam::tools
