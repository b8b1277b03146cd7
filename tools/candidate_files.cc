#include "candidate_files.h"

#include <string>
#include <system_error>

#include "deepslam/artifact/proposals_json.h"
#include "deepslam/artifact/registrations_json.h"
#include "deepslam/storage/store.h"
#include "eval_data.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;

Status AddCandidates(const fs::path& workspace, const std::string& stage, CandidateFiles& files) {
  const fs::path file = workspace / stage / "candidates.json";
  const Result<std::string> text = storage::ReadFile(file);
  if (!text.ok()) return text.error();
  const Result<Proposals> proposals = artifact::DecodeProposals(*text, file.string());
  if (!proposals.ok()) return proposals.error();
  for (const ShapeCandidate& candidate : proposals->candidates) {
    files.candidates.emplace(candidate.id, candidate);
    files.stages.emplace(candidate.id, stage);
  }
  return Ok();
}

// Later stages have the last word.
Status AddRegistrations(const fs::path& file, CandidateFiles& files) {
  const Result<std::string> text = storage::ReadFile(file);
  if (!text.ok()) return text.error();
  const auto registrations = artifact::DecodeRegistrations(*text, file.string());
  if (!registrations.ok()) return registrations.error();
  for (const CandidateRegistration& registration : *registrations)
    files.registrations.insert_or_assign(registration.candidate, registration);
  return Ok();
}

}  // namespace

Result<CandidateFiles> ReadCandidateFiles(const fs::path& workspace) {
  CandidateFiles files;
  Status status = AddCandidates(workspace, "propose", files);
  if (status.ok()) status = AddRegistrations(workspace / "register" / "registrations.json", files);
  // Workspaces of before there was refinement have none of these.
  for (const std::string stage : {"select", "loops"}) {
    std::error_code error;
    if (!status.ok() || !fs::exists(workspace / stage / "candidates.json", error)) continue;
    status = AddCandidates(workspace, stage, files);
    const fs::path registrations = workspace / stage / "registrations.json";
    if (status.ok() && fs::exists(registrations, error))
      status = AddRegistrations(registrations, files);
  }
  if (!status.ok()) return status.error();
  return files;
}

Result<VoxelGrid> ReadCandidateModel(const fs::path& workspace,
                                     const CandidateFiles& files,
                                     const ShapeCandidate& candidate) {
  return ReadGrid(workspace / files.stages.at(candidate.id) / "models" /
                  (candidate.model + ".binvox"));
}

}  // namespace deepslam::tools
