// `deepslam eval selection`: which of an object's candidates was taken, and how good each was.
#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <tuple>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "candidate_files.h"
#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/scene_json.h"
#include "deepslam/artifact/trajectory_files.h"
#include "deepslam/eval/shape_similarity.h"
#include "deepslam/eval/unseen_surface.h"
#include "deepslam/shape/stretch.h"
#include "deepslam/storage/store.h"
#include "eval_commands.h"
#include "eval_data.h"
#include "eval_unseen.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;
using artifact::JsonArray;
using artifact::JsonObject;
using artifact::JsonValue;

constexpr std::uint64_t kBootstrapSeed = 1;  // any, always the same: intervals are repeatable

struct ShapeFigures {
  std::vector<double> iou_sweep;
  double chamfer = 0;
  double unseen_share = 0;  // eval/unseen_surface.h; 0 where nobody asked
};

struct ScoredCandidate {
  CandidateId id;
  CandidateSource source = CandidateSource::kRetrieval;
  DetectionId view;  // that proposed it, as ShapeCandidate::view
  ShapeFigures figures;
};

// One object's candidates as they were proposed, and what was refined of them; the chain's own
// opinion best first.
struct ObjectCandidates {
  std::string name;
  std::string capture;
  std::string class_name;
  int true_number = 0;  // in the truth's list, from 1
  std::vector<ScoredCandidate> candidates;
  std::vector<ScoredCandidate> refined;
  CandidateId greedy;
  CandidateId selected;  // of `candidates`
  CandidateId final;     // of either
};

// What the command was asked beside its pairs.
struct Question {
  std::string annotation;  // file in place of the truth's; empty: that
  bool unseen = false;     // how much of the unseen surface is right, as well
  std::string json_file;   // empty: standard output
};

// What stages propose, register and select left.
struct Proposed {
  CandidateFiles files;
  Pose3 truth_from_tracking;
};

Result<Proposed> ReadProposed(const fs::path& workspace, const Truth& truth) {
  Result<CandidateFiles> files = ReadCandidateFiles(workspace);
  if (!files.ok()) return files.error();
  Proposed proposed{std::move(files).value(), {}};
  const fs::path poses_file = workspace / "track" / "trajectory.tum";
  const Result<std::string> tum = storage::ReadFile(poses_file);
  if (!tum.ok()) return tum.error();
  const auto decoded = artifact::DecodeTum(*tum, poses_file.string());
  if (!decoded.ok()) return decoded.error();
  std::vector<TimedPose> poses;
  for (const artifact::StampedPose& pose : *decoded)
    poses.push_back({pose.time_s, pose.world_from_camera});
  const Result<TrajectoryError> error =
      ComputeTrajectoryError(poses, truth.poses, TrajectoryErrorOptions());
  if (!error.ok()) return InvalidInput(poses_file.string() + ": " + error.error().message);
  proposed.truth_from_tracking = error->truth_from_estimate;
  return proposed;
}

// As the candidate stands: turned by quarters before it is compared, since fused shapes have no
// front of their own.
Result<ShapeFigures> CompareAsPlaced(const VoxelGrid& grid,
                                     const CandidateRegistration& registration,
                                     const Proposed& proposed,
                                     const TrueObject& truth,
                                     std::span<const Eigen::Vector3d> unseen) {
  const int quarters = eval::QuarterTurnsAsPlaced(
      proposed.truth_from_tracking * registration.world_from_object, truth.box.world_from_object);
  const eval::Volume ours(shape::TurnGrid(grid, quarters));
  const Result<eval::Volume> volume = eval::NormaliseForIou(ours);
  if (!volume.ok()) return volume.error();
  const Result<eval::Volume> true_volume = eval::NormaliseForIou(eval::Volume(truth.grid));
  if (!true_volume.ok()) return true_volume.error();
  const auto points = eval::SampleForChamfer(ours, kChamferSeed);
  if (!points.ok()) return points.error();
  const auto true_points = eval::SampleForChamfer(eval::Volume(truth.grid), kChamferSeed);
  if (!true_points.ok()) return true_points.error();
  ShapeFigures figures{eval::IouPerThreshold(*volume, *true_volume),
                       eval::ChamferDistance(*points, *true_points)};
  if (!unseen.empty()) {
    figures.unseen_share = eval::ShareOnSurface(
        shape::ShapeModel(grid),
        Similarity3::From(proposed.truth_from_tracking * registration.world_from_object,
                          registration.scale_m),
        unseen);
  }
  return figures;
}

Result<ObjectCandidates> ScoreCandidates(const fs::path& workspace,
                                         const MappedObject& mapped,
                                         const Proposed& proposed,
                                         const TrueObject& truth,
                                         std::span<const Eigen::Vector3d> unseen) {
  ObjectCandidates object;
  object.class_name = truth.box.class_name;
  object.true_number = truth.number;
  object.name = mapped.name;
  object.final = mapped.object.chosen;
  object.greedy =
      mapped.object.history.empty() ? object.final : mapped.object.history.back().candidate;
  for (const CandidateScore& score : mapped.object.scores) {
    const auto candidate = proposed.files.candidates.find(score.candidate);
    const auto registration = proposed.files.registrations.find(score.candidate);
    if (candidate == proposed.files.candidates.end() ||
        registration == proposed.files.registrations.end() || !registration->second.ok)
      continue;
    const Result<VoxelGrid> grid = ReadCandidateModel(workspace, proposed.files, candidate->second);
    if (!grid.ok()) return grid.error();
    Result<ShapeFigures> figures =
        CompareAsPlaced(*grid, registration->second, proposed, truth, unseen);
    if (!figures.ok()) return figures.error();
    const bool is_derived = TraitsOf(candidate->second.source).is_derived;
    auto& those = is_derived ? object.refined : object.candidates;
    those.push_back({score.candidate,
                     candidate->second.source,
                     candidate->second.view,
                     std::move(figures).value()});
    if (!is_derived && (!object.selected.valid() || score.candidate == object.final))
      object.selected = score.candidate;
  }
  return object;
}

Status AddPair(const EvalPair& pair,
               const Question& question,
               std::vector<ObjectCandidates>& objects) {
  const Result<Truth> truth = ReadTruth(pair.truth, question.annotation);
  if (!truth.ok()) return truth.error();
  std::vector<std::vector<Eigen::Vector3d>> unseen(truth->objects.size());
  if (question.unseen) {
    auto points = UnseenPoints(*truth);
    if (!points.ok()) return points.error();
    unseen = std::move(points).value();
  }
  const Result<MapResult> map = ReadMapResult(pair.workspace, *truth);
  if (!map.ok()) return map.error();
  const Result<Proposed> proposed = ReadProposed(pair.workspace, *truth);
  if (!proposed.ok()) return proposed.error();
  for (const eval::Match& match :
       eval::MatchObjects(BoxesOf(*map), BoxesOf(*truth), eval::PlacementOptions())) {
    const TrueObject& true_object = truth->objects[match.truth];
    if (!match.same_class || !true_object.has_shape) continue;
    Result<ObjectCandidates> object = ScoreCandidates(
        pair.workspace, map->objects[match.estimated], *proposed, true_object, unseen[match.truth]);
    if (!object.ok()) return object.error();
    object->capture = pair.truth.string();
    if (!object->candidates.empty()) objects.push_back(std::move(object).value());
  }
  return Ok();
}

double Peak(const ShapeFigures& figures) {
  return *std::max_element(figures.iou_sweep.begin(), figures.iou_sweep.end());
}

const ShapeFigures* Find(const ObjectCandidates& object, CandidateId id) {
  for (const auto* those : {&object.candidates, &object.refined}) {
    for (const ScoredCandidate& candidate : *those) {
      if (candidate.id == id) return &candidate.figures;
    }
  }
  return nullptr;
}

// The paper starts with what its network makes of the object's first view; without a network, with
// the first candidate there is.
const ShapeFigures* Initial(const ObjectCandidates& object) {
  const auto key = [](const ScoredCandidate& candidate) {
    const bool is_network = candidate.source == CandidateSource::kNetwork;
    return std::tuple(!is_network, is_network ? candidate.view : DetectionId(), candidate.id);
  };
  const auto first = std::min_element(object.candidates.begin(),
                                      object.candidates.end(),
                                      [&](auto& a, auto& b) { return key(a) < key(b); });
  return &first->figures;
}

const ShapeFigures* Oracle(const ObjectCandidates& object) {
  const auto best =
      std::max_element(object.candidates.begin(), object.candidates.end(), [](auto& a, auto& b) {
        return Peak(a.figures) < Peak(b.figures);
      });
  return &best->figures;
}

ShapeFigures Mean(const ObjectCandidates& object) {
  ShapeFigures mean{std::vector<double>(eval::kNumIouThresholds, 0.0), 0, 0};
  const auto count = static_cast<double>(object.candidates.size());
  for (const ScoredCandidate& candidate : object.candidates) {
    for (std::size_t n = 0; n < mean.iou_sweep.size(); ++n)
      mean.iou_sweep[n] += candidate.figures.iou_sweep[n] / count;
    mean.chamfer += candidate.figures.chamfer / count;
    mean.unseen_share += candidate.figures.unseen_share / count;
  }
  return mean;
}

// A way to choose: one entry per object, nothing where it has no candidate of that kind.
struct Row {
  std::string name;
  std::vector<const ShapeFigures*> chosen;
};

std::vector<Row> RowsOf(const std::vector<ObjectCandidates>& objects,
                        const std::vector<ShapeFigures>& means) {
  std::vector<Row> rows = {{"initial", {}},
                           {"greedy", {}},
                           {"selected", {}},
                           {"mean of all", {}},
                           {"oracle", {}},
                           {"retrieval only", {}},
                           {"fused only", {}},
                           {"network only", {}},
                           {"mean latent only", {}},
                           {"refined only", {}},
                           {"completed only", {}},
                           {"with refinement", {}}};
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const ObjectCandidates& object = objects[i];
    rows[0].chosen.push_back(Initial(object));
    rows[1].chosen.push_back(Find(object, object.greedy));
    rows[2].chosen.push_back(Find(object, object.selected));
    rows[3].chosen.push_back(&means[i]);
    rows[4].chosen.push_back(Oracle(object));
    std::size_t row = 5;
    for (const CandidateSource source : {CandidateSource::kRetrieval,
                                         CandidateSource::kFused,
                                         CandidateSource::kNetwork,
                                         CandidateSource::kMeanLatent}) {
      const auto best = std::find_if(object.candidates.begin(),
                                     object.candidates.end(),
                                     [&](const ScoredCandidate& c) { return c.source == source; });
      rows[row++].chosen.push_back(best == object.candidates.end() ? nullptr : &best->figures);
    }
    for (const CandidateSource source : {CandidateSource::kRefined, CandidateSource::kCompleted}) {
      const auto best = std::find_if(object.refined.begin(),
                                     object.refined.end(),
                                     [&](const ScoredCandidate& c) { return c.source == source; });
      rows[row++].chosen.push_back(best == object.refined.end() ? nullptr : &best->figures);
    }
    rows[row].chosen.push_back(Find(object, object.final));
  }
  return rows;
}

// A row beside `initial`, over the objects that have both.
JsonValue RowJson(const Row& row, const Row& initial, bool with_unseen) {
  std::vector<std::vector<double>> sweeps;
  std::vector<std::vector<double>> initial_sweeps;
  std::vector<double> chamfer;
  std::vector<double> chamfer_gain;
  std::vector<double> unseen;
  for (std::size_t i = 0; i < row.chosen.size(); ++i) {
    if (row.chosen[i] == nullptr) continue;
    sweeps.push_back(row.chosen[i]->iou_sweep);
    initial_sweeps.push_back(initial.chosen[i]->iou_sweep);
    chamfer.push_back(row.chosen[i]->chamfer);
    unseen.push_back(row.chosen[i]->unseen_share);
    chamfer_gain.push_back(row.chosen[i]->chamfer - initial.chosen[i]->chamfer);
  }
  const eval::SetIou iou = eval::BestOverSet(sweeps);
  const eval::SetIou initial_iou = eval::BestOverSet(initial_sweeps);
  std::vector<double> iou_gain;
  for (std::size_t i = 0; i < iou.each.size(); ++i)
    iou_gain.push_back(iou.each[i] - initial_iou.each[i]);
  const eval::Interval gain = eval::BootstrapMean(iou_gain, kBootstrapSeed);
  const eval::Interval mean_chamfer = eval::BootstrapMean(chamfer, kBootstrapSeed);
  const eval::Interval chamfer_change = eval::BootstrapMean(chamfer_gain, kBootstrapSeed);
  const eval::Interval mean_unseen = eval::BootstrapMean(unseen, kBootstrapSeed);
  if (!sweeps.empty()) {
    fmt::print(stderr,
               "{:<18} {:>3} {:>7.4f} {:>+8.4f} [{:+.4f}, {:+.4f}] {:>7.4f} {:>+8.4f} [{:+.4f}, "
               "{:+.4f}]{}\n",
               row.name,
               sweeps.size(),
               iou.mean,
               gain.mean,
               gain.low,
               gain.high,
               mean_chamfer.mean,
               chamfer_change.mean,
               chamfer_change.low,
               chamfer_change.high,
               with_unseen ? fmt::format(" {:>6.1f} %", 100 * mean_unseen.mean) : "");
  }
  JsonObject json;
  json.emplace("row", row.name);
  json.emplace("num_objects", static_cast<int>(sweeps.size()));
  json.emplace("iou", iou.mean);
  json.emplace("iou_threshold", iou.threshold);
  json.emplace("iou_minus_initial", ToJson(gain));
  json.emplace("chamfer", mean_chamfer.mean);
  json.emplace("chamfer_minus_initial", ToJson(chamfer_change));
  if (with_unseen) json.emplace("unseen_share", ToJson(mean_unseen));
  JsonArray each;
  for (const double value : iou.each) each.emplace_back(value);
  json.emplace("iou_each", std::move(each));
  return JsonValue(std::move(json));
}

JsonArray ObjectRows(const std::vector<ObjectCandidates>& objects, bool with_unseen) {
  JsonArray rows;
  for (const ObjectCandidates& object : objects) {
    JsonObject row;
    row.emplace("mapped", object.name);
    row.emplace("capture", object.capture);
    row.emplace("class", object.class_name);
    row.emplace("true_number", object.true_number);
    JsonArray candidates;
    for (const auto* those : {&object.candidates, &object.refined}) {
      for (const ScoredCandidate& candidate : *those) {
        JsonObject entry;
        entry.emplace("candidate", artifact::ToJson(candidate.id));
        entry.emplace("source", NameOf(candidate.source));
        entry.emplace("iou_peak", Peak(candidate.figures));
        entry.emplace("chamfer", candidate.figures.chamfer);
        if (with_unseen) entry.emplace("unseen_share", candidate.figures.unseen_share);
        candidates.emplace_back(std::move(entry));
      }
    }
    row.emplace("candidates", std::move(candidates));
    row.emplace("selected", artifact::ToJson(object.selected));
    row.emplace("greedy", artifact::ToJson(object.greedy));
    row.emplace("final", artifact::ToJson(object.final));
    rows.emplace_back(std::move(row));
  }
  return rows;
}

int EvalSelection(const std::vector<std::string>& paths, const Question& question) {
  const Result<std::vector<EvalPair>> pairs = PairsOf(paths);
  if (!pairs.ok()) return ReportError(pairs.error());
  std::vector<ObjectCandidates> objects;
  for (const EvalPair& pair : *pairs) {
    if (Status status = AddPair(pair, question, objects); !status.ok())
      return ReportError(status.error());
  }
  if (objects.empty())
    return ReportError(
        InvalidInput("no mapped object matches a true one whose mesh is known: nothing to score"));
  std::vector<ShapeFigures> means;
  for (const ObjectCandidates& object : objects) means.push_back(Mean(object));
  const std::vector<Row> rows = RowsOf(objects, means);
  fmt::print(stderr,
             "{:<18} {:>3} {:>7} {:>26} {:>8} {:>26}{}\n",
             "choice",
             "n",
             "IoU",
             "- initial [95 %]",
             "CD",
             "- initial [95 %]",
             question.unseen ? "   unseen" : "");
  JsonArray row_json;
  for (const Row& row : rows) row_json.push_back(RowJson(row, rows.front(), question.unseen));
  JsonObject document = artifact::NewDocument("deepslam/eval_selection", 1);
  JsonObject protocols;
  protocols.emplace("iou", eval::kPix3dIou);
  protocols.emplace("chamfer", eval::kPix3dChamfer);
  protocols.emplace("pose", "models turned by quarters as they are placed");
  protocols.emplace("interval", "paired percentile bootstrap over objects, 95 %, 10,000 resamples");
  protocols.emplace(
      "initial",
      "the network's candidate of the earliest view that proposed; without networks, the "
      "first candidate");
  if (question.unseen) protocols.emplace("unseen_share", eval::kUnseenProtocol);
  document.emplace("protocols", std::move(protocols));
  document.emplace("rows", std::move(row_json));
  document.emplace("objects", ObjectRows(objects, question.unseen));
  const Result<std::string> text = DumpJson(std::move(document), "selection");
  const Status status = text.ok() ? WriteResult(question.json_file, *text) : Status(text.error());
  return status.ok() ? kExitOk : ReportError(status.error());
}

}  // namespace

void AddEvalSelection(CLI::App& eval_command, Command& chosen) {
  struct Arguments {
    std::vector<std::string> paths;
    Question question;
    bool held_out = false;
    std::string judge_by;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = eval_command.add_subcommand(
      "selection", "Shape of the first, the chosen and the best candidate against the truth");
  command
      ->add_option("PATHS",
                   arguments->paths,
                   "WORKSPACE TRUTH, or several such pairs that are scored as one set")
      ->required();
  command->add_option(
      "--annotation", arguments->question.annotation, "Annotation file in place of TRUTH's");
  command->add_option("--json",
                      arguments->question.json_file,
                      "Write the result here instead of to standard output");
  command->add_flag(
      "--unseen",
      arguments->question.unseen,
      "Also how much of the surface that no frame saw lies within 5 cm of each model; "
      "of captures with instance masks");
  command->add_flag("--held-out",
                    arguments->held_out,
                    "Without truth: agreement with the depth of frames no view comes from; the "
                    "second of each pair is the capture");
  command->add_option("--judge-by",
                      arguments->judge_by,
                      "With --held-out: workspace of the same capture made of other detections, "
                      "whose views score (scripts/experiments/halves.py)");
  command->callback([&chosen, arguments] {
    chosen = [arguments] {
      if (arguments->held_out)
        return EvalHeldOut(arguments->paths, arguments->judge_by, arguments->question.json_file);
      if (!arguments->judge_by.empty())
        return ReportError(InvalidConfig("--judge-by: only with --held-out"));
      return EvalSelection(arguments->paths, arguments->question);
    };
  });
}

}  // namespace deepslam::tools
