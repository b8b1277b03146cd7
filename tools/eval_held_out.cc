// `deepslam eval selection --held-out`: on captures without truth, candidates against depth of
// frames that had no part in choosing them.
#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>

#include "candidate_files.h"
#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/objects_json.h"
#include "deepslam/artifact/store.h"
#include "deepslam/artifact/trajectory_files.h"
#include "deepslam/dataset/capture.h"
#include "deepslam/eval/held_out.h"
#include "deepslam/mesh/extract_surface.h"
#include "deepslam/pipeline/consistency.h"
#include "deepslam/stages/stage_inputs.h"
#include "eval_commands.h"
#include "eval_data.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;
using artifact::JsonArray;
using artifact::JsonObject;
using artifact::JsonValue;

constexpr std::size_t kMaxHeldOutFrames = 20;  // spread over the capture

struct Inputs {
  dataset::Capture capture;
  std::vector<TrackedFrame> frames;
  ObjectMap map;
  CandidateFiles files;
};

template <typename Value, typename Decode>
Result<Value> DecodeFile(const fs::path& file, Decode decode) {
  const Result<std::string> text = artifact::ReadFile(file);
  if (!text.ok()) return text.error();
  return decode(*text, file.string());
}

Result<Inputs> ReadInputs(const fs::path& workspace, const fs::path& capture_folder) {
  if (Status status = pipeline::CheckConsistency(workspace); !status.ok()) return status.error();
  Result<dataset::Capture> capture = dataset::OpenCapture(capture_folder);
  if (!capture.ok()) return capture.error();
  const Result<std::string> tum = artifact::ReadFile(workspace / "track" / "trajectory.tum");
  if (!tum.ok()) return tum.error();
  const auto table = DecodeFile<artifact::FrameTable>(
      workspace / "track" / "frames.json", [&](std::string_view text, std::string_view name) {
        return artifact::DecodeFrames(text, *tum, name);
      });
  if (!table.ok()) return table.error();
  if (static_cast<int>(table->frames.size()) != capture->frames->num_frames())
    return InvalidInput(fmt::format("{}: holds {} frames, the workspace {}: not of one capture",
                                    capture_folder.string(),
                                    capture->frames->num_frames(),
                                    table->frames.size()));
  Result<ObjectMap> map =
      DecodeFile<ObjectMap>(workspace / "loops" / "objects.json", artifact::DecodeObjectMap);
  if (!map.ok()) return map.error();
  Result<CandidateFiles> files = ReadCandidateFiles(workspace);
  if (!files.ok()) return files.error();
  return Inputs{
      std::move(capture).value(), table->frames, std::move(map).value(), std::move(files).value()};
}

// Tracked frames that no view of the object comes from, spread over the capture.
std::vector<FrameIdx> HeldOutFrames(const Inputs& inputs, const MapObject& object) {
  std::set<FrameIdx> used;
  for (const ViewRegistration& view : object.views) used.insert(view.frame);
  std::vector<FrameIdx> all;
  for (const TrackedFrame& frame : inputs.frames) {
    if (frame.status == TrackingStatus::kTracked && !used.contains(frame.frame))
      all.push_back(frame.frame);
  }
  std::vector<FrameIdx> spread;
  const std::size_t count = std::min(all.size(), kMaxHeldOutFrames);
  for (std::size_t n = 0; n < count; ++n) spread.push_back(all[n * all.size() / count]);
  return spread;
}

struct Choice {
  std::string row;
  CandidateId candidate;
};

std::vector<Choice> ChoicesOf(const MapObject& object, const Inputs& inputs) {
  CandidateId first;
  CandidateId as_proposed;  // the best that was not refined
  CandidateId refined;
  CandidateId completed;
  for (const CandidateScore& score : object.scores) {
    const auto found = inputs.files.registrations.find(score.candidate);
    if (found == inputs.files.registrations.end() || !found->second.ok) continue;
    if (!first.valid() || score.candidate < first) first = score.candidate;
    const auto candidate = inputs.files.candidates.find(score.candidate);
    if (candidate == inputs.files.candidates.end()) continue;
    const CandidateSource source = candidate->second.source;
    const bool is_refined = source == CandidateSource::kRefined;
    const bool is_completed = source == CandidateSource::kCompleted;
    if (is_refined && !refined.valid()) refined = score.candidate;
    if (is_completed && !completed.valid()) completed = score.candidate;
    if (!is_refined && !is_completed && !as_proposed.valid()) as_proposed = score.candidate;
  }
  const CandidateId greedy =
      object.history.empty() ? object.chosen : object.history.back().candidate;
  return {{"initial", first},
          {"greedy", greedy},
          {"as proposed", as_proposed},
          {"refined", refined},
          {"completed", completed},
          {"selected", object.chosen}};
}

Result<eval::HeldOutAgreement> Judge(const fs::path& workspace,
                                     const Inputs& inputs,
                                     CandidateId candidate,
                                     const std::vector<FrameIdx>& frames) {
  const auto proposed = inputs.files.candidates.find(candidate);
  const auto registration = inputs.files.registrations.find(candidate);
  eval::HeldOutAgreement sum;
  if (proposed == inputs.files.candidates.end() || registration == inputs.files.registrations.end())
    return sum;
  const Result<VoxelGrid> grid = ReadCandidateModel(workspace, inputs.files, proposed->second);
  if (!grid.ok()) return grid.error();
  Result<TriangleMesh> mesh = mesh::ExtractSurface(*grid, mesh::SurfaceOptions());
  if (!mesh.ok()) return mesh.error();
  for (Eigen::Vector3f& vertex : mesh->vertices)
    vertex *= static_cast<float>(registration->second.scale_m);
  for (const FrameIdx idx : frames) {
    const Result<Frame> frame = inputs.capture.frames->ReadDepth(idx);
    if (!frame.ok()) continue;  // unusable for the run as well
    const Pose3 camera_from_object =
        inputs.frames[static_cast<std::size_t>(idx.value)].world_from_camera.Inverse() *
        registration->second.world_from_object;
    sum += eval::JudgeHeldOut(
        *mesh, camera_from_object, inputs.capture.frames->camera(), frame->depth_m);
  }
  return sum;
}

}  // namespace

int EvalHeldOut(const std::vector<std::string>& paths, const std::string& json_file) {
  const Result<std::vector<EvalPair>> pairs = PairsOf(paths);
  if (!pairs.ok()) return ReportError(pairs.error());
  JsonArray rows;
  std::map<std::string, std::vector<double>> shares;
  for (const EvalPair& pair : *pairs) {
    const Result<Inputs> inputs = ReadInputs(pair.workspace, pair.truth);
    if (!inputs.ok()) return ReportError(inputs.error());
    for (const MapObject& object : inputs->map.objects) {
      const std::vector<FrameIdx> frames = HeldOutFrames(*inputs, object);
      JsonObject row;
      row.emplace("mapped", stages::ObjectName(object));
      row.emplace("num_frames", static_cast<int>(frames.size()));
      for (const Choice& choice : ChoicesOf(object, *inputs)) {
        const auto judged = Judge(pair.workspace, *inputs, choice.candidate, frames);
        if (!judged.ok()) return ReportError(judged.error());
        JsonObject entry;
        entry.emplace("agreement", judged->agreement());
        entry.emplace("num_judged", judged->num_judged());
        entry.emplace("num_violated", judged->num_violated);
        row.emplace(choice.row, std::move(entry));
        if (judged->num_judged() > 0) shares[choice.row].push_back(judged->agreement());
      }
      rows.emplace_back(std::move(row));
    }
  }
  JsonObject document = artifact::NewDocument("deepslam/eval_held_out", 1);
  document.emplace("protocol", eval::kHeldOutProtocol);
  document.emplace("objects", std::move(rows));
  for (const auto& [name, values] : shares) {
    const eval::Interval mean = eval::BootstrapMean(values, 1);
    fmt::print(stderr,
               "{:<11} {:>3} objects, {:.4f} [{:.4f}, {:.4f}] of the judged pixels within 2 cm\n",
               name,
               values.size(),
               mean.mean,
               mean.low,
               mean.high);
    document.emplace(name, ToJson(mean));
  }
  const Result<std::string> text = DumpJson(std::move(document), "held-out agreement");
  const Status status = text.ok() ? WriteResult(json_file, *text) : Status(text.error());
  return status.ok() ? kExitOk : ReportError(status.error());
}

}  // namespace deepslam::tools
