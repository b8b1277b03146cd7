// `deepslam eval selection --held-out`: on captures without truth, candidates against depth of
// frames that had no part in choosing them: of frames spread over the capture, or of the views of a
// workspace that was made of other detections in the same capture.
#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "candidate_files.h"
#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/objects_json.h"
#include "deepslam/artifact/segments_json.h"
#include "deepslam/artifact/trajectory_files.h"
#include "deepslam/eval/held_out.h"
#include "deepslam/layouts/open_capture.h"
#include "deepslam/mesh/extract_surface.h"
#include "deepslam/pipeline/consistency.h"
#include "deepslam/stages/stage_inputs.h"
#include "deepslam/storage/store.h"
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
  const Result<std::string> text = storage::ReadFile(file);
  if (!text.ok()) return text.error();
  return decode(*text, file.string());
}

Result<ObjectMap> ReadMap(const fs::path& workspace) {
  return DecodeFile<ObjectMap>(workspace / "loops" / "objects.json", artifact::DecodeObjectMap);
}

Result<std::string> ReadTracking(const fs::path& workspace) {
  return storage::ReadFile(workspace / "track" / "trajectory.tum");
}

std::set<FrameIdx> FramesOf(const MapObject& object) {
  std::set<FrameIdx> frames;
  for (const ViewRegistration& view : object.views) frames.insert(view.frame);
  return frames;
}

Result<Inputs> ReadInputs(const fs::path& workspace, const fs::path& capture_folder) {
  if (Status status = pipeline::CheckConsistency(workspace); !status.ok()) return status.error();
  Result<dataset::Capture> capture = layouts::OpenCapture(capture_folder);
  if (!capture.ok()) return capture.error();
  const Result<std::string> tum = ReadTracking(workspace);
  if (!tum.ok()) return tum.error();
  const auto table = DecodeFile<Trajectory>(workspace / "track" / "frames.json",
                                            [&](std::string_view text, std::string_view name) {
                                              return artifact::DecodeTrajectory(text, *tum, name);
                                            });
  if (!table.ok()) return table.error();
  if (static_cast<int>(table->frames.size()) != capture->frames->num_frames())
    return InvalidInput(fmt::format("{}: holds {} frames, the workspace {}: not of one capture",
                                    capture_folder.string(),
                                    capture->frames->num_frames(),
                                    table->frames.size()));
  Result<ObjectMap> map = ReadMap(workspace);
  if (!map.ok()) return map.error();
  Result<CandidateFiles> files = ReadCandidateFiles(workspace);
  if (!files.ok()) return files.error();
  return Inputs{
      std::move(capture).value(), table->frames, std::move(map).value(), std::move(files).value()};
}

// A frame that scores, and what it shows of the object, where that is known.
struct ScoringView {
  FrameIdx frame;
  const PixelMask* mask = nullptr;
};

// Tracked frames that no view of the object comes from, spread over the capture.
std::vector<ScoringView> HeldOutFrames(const Inputs& inputs, const MapObject& object) {
  const std::set<FrameIdx> used = FramesOf(object);
  std::vector<FrameIdx> all;
  for (const TrackedFrame& frame : inputs.frames) {
    if (frame.status == TrackingStatus::kTracked && !used.contains(frame.frame))
      all.push_back(frame.frame);
  }
  std::vector<ScoringView> spread;
  const std::size_t count = std::min(all.size(), kMaxHeldOutFrames);
  for (std::size_t n = 0; n < count; ++n) spread.push_back({all[n * all.size() / count]});
  return spread;
}

// A workspace whose views score: same capture and tracking, other detections.
struct Bench {
  ObjectMap map;
  std::map<DetectionId, Segment> segments;
};

Result<Bench> ReadBench(const fs::path& workspace, const fs::path& scored_workspace) {
  if (Status status = pipeline::CheckConsistency(workspace); !status.ok()) return status.error();
  const Result<std::string> own = ReadTracking(scored_workspace);
  if (!own.ok()) return own.error();
  const Result<std::string> tum = ReadTracking(workspace);
  if (!tum.ok()) return tum.error();
  if (*tum != *own) {
    return InvalidInput(
        fmt::format("{}: tracked otherwise than {}; score by a workspace of the same capture with "
                    "the same options of track",
                    workspace.string(),
                    scored_workspace.string()));
  }
  Result<ObjectMap> map = ReadMap(workspace);
  if (!map.ok()) return map.error();
  const auto segments = DecodeFile<std::vector<Segment>>(workspace / "associate" / "segments.json",
                                                         artifact::DecodeSegments);
  if (!segments.ok()) return segments.error();
  Bench bench{std::move(map).value(), {}};
  for (const Segment& segment : *segments) bench.segments.emplace(segment.detection, segment);
  return bench;
}

// The views of the object of the same class that stands nearest, in frames that no view of the
// scored one comes from; none where nothing stands near.
std::vector<ScoringView> ViewsThere(const Bench& bench, const MapObject& object) {
  constexpr double kSameObjectM = 0.5;  // what is farther off is another object
  const MapObject* nearest = nullptr;
  double least_m = kSameObjectM;
  for (const MapObject& other : bench.map.objects) {
    const double distance_m =
        (other.world_from_object.translation_m - object.world_from_object.translation_m).norm();
    if (other.class_name != object.class_name || distance_m > least_m) continue;
    nearest = &other;
    least_m = distance_m;
  }
  std::vector<ScoringView> views;
  if (nearest == nullptr) return views;
  const std::set<FrameIdx> used = FramesOf(object);
  for (const ViewRegistration& view : nearest->views) {
    const auto segment = bench.segments.find(view.view);
    if (segment != bench.segments.end() && !used.contains(view.frame))
      views.push_back({view.frame, &segment->second.mask});
  }
  return views;
}

struct Choice {
  std::string row;
  CandidateId candidate;
};

std::optional<CandidateSource> SourceOf(const Inputs& inputs, CandidateId candidate) {
  const auto registered = inputs.files.registrations.find(candidate);
  if (registered == inputs.files.registrations.end() || !registered->second.ok) return std::nullopt;
  const auto proposed = inputs.files.candidates.find(candidate);
  if (proposed == inputs.files.candidates.end()) return std::nullopt;
  return proposed->second.source;
}

// What selection scored, the best first; of each row the best that belongs to it, if there is one.
std::vector<Choice> ChoicesOf(const MapObject& object, const Inputs& inputs) {
  const auto best = [&](const auto& belongs) {
    for (const CandidateScore& score : object.scores) {
      const std::optional<CandidateSource> source = SourceOf(inputs, score.candidate);
      if (source && belongs(*source)) return score.candidate;
    }
    return CandidateId();
  };
  const auto of = [&](CandidateSource wanted) {
    return best([&](CandidateSource source) { return source == wanted; });
  };
  CandidateId first;
  for (const CandidateScore& score : object.scores) {
    const bool earlier = !first.valid() || score.candidate < first;
    if (earlier && SourceOf(inputs, score.candidate)) first = score.candidate;
  }
  const CandidateId greedy =
      object.history.empty() ? object.chosen : object.history.back().candidate;
  return {
      {"initial", first},
      {"greedy", greedy},
      {"as proposed", best([](CandidateSource source) { return !TraitsOf(source).is_derived; })},
      {"retrieval", of(CandidateSource::kRetrieval)},
      {"network", of(CandidateSource::kNetwork)},
      {"mean latent", of(CandidateSource::kMeanLatent)},
      {"fused", of(CandidateSource::kFused)},
      {"refined", of(CandidateSource::kRefined)},
      {"completed", of(CandidateSource::kCompleted)},
      {"selected", object.chosen}};
}

struct Verdict {
  eval::HeldOutAgreement agreement;  // of the rendered model
  eval::MeasuredShare measured;      // of the object's depth, where views score
};

Result<Verdict> ScoreCandidate(const fs::path& workspace,
                               const Inputs& inputs,
                               CandidateId candidate,
                               const std::vector<ScoringView>& scoring_views) {
  const auto proposed = inputs.files.candidates.find(candidate);
  const auto registration = inputs.files.registrations.find(candidate);
  Verdict verdict;
  if (proposed == inputs.files.candidates.end() || registration == inputs.files.registrations.end())
    return verdict;
  const Result<VoxelGrid> grid = ReadCandidateModel(workspace, inputs.files, proposed->second);
  if (!grid.ok()) return grid.error();
  Result<TriangleMesh> mesh = mesh::ExtractSurface(*grid, mesh::SurfaceOptions());
  if (!mesh.ok()) return mesh.error();
  const double scale_m = registration->second.scale_m;
  for (Eigen::Vector3f& vertex : mesh->vertices) vertex *= static_cast<float>(scale_m);
  const shape::ShapeModel model(*grid);
  const PinholeCamera& camera = inputs.capture.frames->camera();
  for (const ScoringView& view : scoring_views) {
    const Result<Frame> frame = inputs.capture.frames->ReadDepth(view.frame);
    if (!frame.ok()) continue;  // unusable for the run as well
    const Pose3 camera_from_object =
        inputs.frames[static_cast<std::size_t>(view.frame.value)].world_from_camera.Inverse() *
        registration->second.world_from_object;
    verdict.agreement += eval::ScoreHeldOut(*mesh, camera_from_object, camera, frame->depth_m);
    if (view.mask == nullptr) continue;
    verdict.measured += eval::ScoreMeasured(model,
                                            Similarity3::From(camera_from_object, scale_m),
                                            camera,
                                            frame->depth_m,
                                            view.mask->Unpacked());
  }
  return verdict;
}

JsonObject VerdictJson(const Verdict& verdict) {
  JsonObject entry;
  entry.emplace("agreement", verdict.agreement.agreement());
  entry.emplace("num_judged", verdict.agreement.num_judged());
  entry.emplace("num_violated", verdict.agreement.num_violated);
  if (verdict.measured.num_measured > 0) {
    entry.emplace("depth_near", verdict.measured.share());
    entry.emplace("num_depth", verdict.measured.num_measured);
  }
  return entry;
}

// Shares of all objects by row.
using Shares = std::map<std::string, std::vector<double>>;

JsonObject MeansOf(const Shares& shares, const char* what) {
  JsonObject means;
  for (const auto& [name, values] : shares) {
    const eval::Interval mean = eval::BootstrapMean(values, 1);
    fmt::print(stderr,
               "{:<11} {:>3} objects, {:.4f} [{:.4f}, {:.4f}] {}\n",
               name,
               values.size(),
               mean.mean,
               mean.low,
               mean.high,
               what);
    means.emplace(name, tools::ToJson(mean));
  }
  return means;
}

}  // namespace

int EvalHeldOut(const std::vector<std::string>& paths,
                const std::string& scoring_workspace,
                const std::string& json_file) {
  const Result<std::vector<EvalPair>> pairs = PairsOf(paths);
  if (!pairs.ok()) return ReportError(pairs.error());
  std::optional<Bench> bench;
  if (!scoring_workspace.empty()) {
    if (pairs->size() != 1)
      return ReportError(InvalidConfig("--judge-by: takes one pair of WORKSPACE CAPTURE"));
    Result<Bench> read = ReadBench(scoring_workspace, pairs->front().workspace);
    if (!read.ok()) return ReportError(read.error());
    bench = std::move(read).value();
  }
  JsonArray rows;
  Shares agreements;
  Shares depths;
  for (const EvalPair& pair : *pairs) {
    const Result<Inputs> inputs = ReadInputs(pair.workspace, pair.truth);
    if (!inputs.ok()) return ReportError(inputs.error());
    for (const MapObject& object : inputs->map.objects) {
      const std::vector<ScoringView> scoring_views =
          bench ? ViewsThere(*bench, object) : HeldOutFrames(*inputs, object);
      JsonObject row;
      row.emplace("mapped", ObjectName(object));
      row.emplace("num_frames", static_cast<int>(scoring_views.size()));
      for (const Choice& choice : ChoicesOf(object, *inputs)) {
        const auto verdict =
            ScoreCandidate(pair.workspace, *inputs, choice.candidate, scoring_views);
        if (!verdict.ok()) return ReportError(verdict.error());
        row.emplace(choice.row, VerdictJson(*verdict));
        if (verdict->agreement.num_judged() > 0)
          agreements[choice.row].push_back(verdict->agreement.agreement());
        if (verdict->measured.num_measured > 0)
          depths[choice.row].push_back(verdict->measured.share());
      }
      rows.emplace_back(std::move(row));
    }
  }
  JsonObject document = artifact::NewDocument("deepslam/eval_held_out", 1);
  document.emplace("protocol", bench ? eval::kOtherViewsProtocol : eval::kHeldOutProtocol);
  document.emplace("objects", std::move(rows));
  for (auto& [name, mean] : MeansOf(agreements, "of the scored pixels within 2 cm"))
    document.emplace(name, std::move(mean));
  if (bench) {
    document.emplace("depth_near", MeansOf(depths, "of the object's depth within 2 cm"));
  }
  const Result<std::string> text = DumpJson(std::move(document), "held-out agreement");
  const Status status = text.ok() ? WriteResult(json_file, *text) : Status(text.error());
  return status.ok() ? kExitOk : ReportError(status.error());
}

}  // namespace deepslam::tools
