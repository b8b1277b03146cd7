// `deepslam eval objects`: mapped objects against the true ones.
#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "deepslam/artifact/json_reader.h"
#include "deepslam/eval/placed_iou.h"
#include "deepslam/eval/shape_similarity.h"
#include "deepslam/shape/stretch.h"
#include "eval_boxes.h"
#include "eval_commands.h"
#include "eval_data.h"
#include "eval_surfaces.h"
#include "number_from.h"

namespace deepslam::tools {
namespace {

using artifact::JsonArray;
using artifact::JsonObject;
using artifact::JsonValue;

struct ObjectScore {
  std::size_t pair = 0;  // of the command line
  std::string mapped_name;
  std::string mapped_class;
  std::string true_class;
  std::size_t true_index = 0;
  eval::PlacementError placement;
  shape::Symmetry symmetry = shape::Symmetry::kNone;
  bool has_shape = false;
  std::vector<double> iou_sweep;         // each in its own canonical pose
  std::vector<double> iou_placed_sweep;  // ours turned by quarters as it stands in the world
  double chamfer = 0;
  double chamfer_placed = 0;
  double in_place_iou = 0;
};

struct Everything {
  std::vector<ObjectScore> objects;
  std::vector<eval::PlacedBox> true_boxes;  // classes only: counts over all pairs
  std::vector<eval::PlacedBox> mapped_boxes;
  std::vector<eval::Match> matches;  // into the two lists above
  BoxFigures boxes;
  JsonArray pairs;
  int num_unseen = 0;
};

// Best over the turns that the truth's symmetry allows.
struct ShapeScore {
  std::vector<double> iou_sweep;
  double chamfer = 0;
};
Result<ShapeScore> CompareShapes(const VoxelGrid& ours,
                                 const VoxelGrid& truth,
                                 shape::Symmetry symmetry) {
  const Result<eval::Volume> true_volume = eval::NormaliseForIou(eval::Volume(truth));
  if (!true_volume.ok()) return true_volume.error();
  const auto true_points = eval::SampleForChamfer(eval::Volume(truth), kChamferSeed);
  if (!true_points.ok()) return true_points.error();
  ShapeScore best;
  double best_iou = -1;
  for (const int quarters : shape::QuarterTurns(symmetry)) {
    const eval::Volume turned(shape::TurnGrid(ours, quarters));
    const Result<eval::Volume> volume = eval::NormaliseForIou(turned);
    if (!volume.ok()) return volume.error();
    const auto points = eval::SampleForChamfer(turned, kChamferSeed);
    if (!points.ok()) return points.error();
    std::vector<double> sweep = eval::IouPerThreshold(*volume, *true_volume);
    const double iou = *std::max_element(sweep.begin(), sweep.end());
    if (iou <= best_iou) continue;
    best_iou = iou;
    best = {std::move(sweep), eval::ChamferDistance(*points, *true_points)};
  }
  return best;
}

Result<ObjectScore> ScoreObject(const MappedObject& mapped,
                                const TrueObject& truth,
                                const eval::PlacementOptions& options) {
  ObjectScore score;
  score.mapped_name = mapped.name;
  score.mapped_class = mapped.box.class_name;
  score.true_class = truth.box.class_name;
  score.symmetry = truth.symmetry;
  score.has_shape = truth.has_shape;
  score.placement = eval::ComparePlacement(
      truth.has_shape ? mapped.box : eval::WithAxesAlongLikeSides(mapped.box, truth.box),
      truth.box,
      truth.symmetry,
      options);
  const Similarity3 world_from_truth = truth.box.world_from_object * eval::MeshFromGrid(truth.mesh);
  score.in_place_iou =
      eval::PlacedIou(mapped.grid,
                      Similarity3::From(mapped.true_world_from_object, mapped.object.scale_m),
                      truth.grid,
                      world_from_truth);
  if (!truth.has_shape) return score;
  const Result<ShapeScore> canonical = CompareShapes(mapped.grid, truth.grid, truth.symmetry);
  if (!canonical.ok()) return canonical.error();
  const int quarters =
      eval::QuarterTurnsAsPlaced(mapped.true_world_from_object, truth.box.world_from_object);
  const Result<ShapeScore> placed =
      CompareShapes(shape::TurnGrid(mapped.grid, quarters), truth.grid, truth.symmetry);
  if (!placed.ok()) return placed.error();
  score.iou_sweep = canonical->iou_sweep;
  score.chamfer = canonical->chamfer;
  score.iou_placed_sweep = placed->iou_sweep;
  score.chamfer_placed = placed->chamfer;
  return score;
}

JsonValue TrajectoryJson(const TrajectoryError& error) {
  JsonObject row;
  row.emplace("ate_rmse_m", error.ate_m.rmse);
  row.emplace("num_scored", error.num_scored);
  row.emplace("num_frames", error.num_frames);
  return JsonValue(std::move(row));
}

Status AddPair(const EvalPair& pair,
               const std::string& annotation,
               const eval::PlacementOptions& options,
               Everything& all) {
  const Result<Truth> truth = ReadTruth(pair.truth, annotation);
  if (!truth.ok()) return truth.error();
  const Result<MapResult> map = ReadMapResult(pair.workspace, *truth);
  if (!map.ok()) return map.error();
  const std::vector<eval::PlacedBox> true_boxes = BoxesOf(*truth);
  const std::vector<eval::PlacedBox> mapped_boxes = BoxesOf(*map);
  const std::size_t pair_index = all.pairs.size();
  for (const eval::Match& match : eval::MatchObjects(mapped_boxes, true_boxes, options)) {
    Result<ObjectScore> score =
        ScoreObject(map->objects[match.estimated], truth->objects[match.truth], options);
    if (!score.ok()) return score.error();
    score->pair = pair_index;
    score->true_index = match.truth;
    if (match.same_class) all.objects.push_back(std::move(score).value());
    all.matches.push_back({match.estimated + all.mapped_boxes.size(),
                           match.truth + all.true_boxes.size(),
                           match.distance_m,
                           match.same_class});
  }
  all.boxes.Add(mapped_boxes, true_boxes, static_cast<int>(pair_index));
  all.true_boxes.insert(all.true_boxes.end(), true_boxes.begin(), true_boxes.end());
  all.mapped_boxes.insert(all.mapped_boxes.end(), mapped_boxes.begin(), mapped_boxes.end());
  all.num_unseen += truth->num_unseen;
  JsonObject row;
  row.emplace("num_true", static_cast<int>(true_boxes.size()));
  row.emplace("num_unseen", truth->num_unseen);
  row.emplace("num_mapped", static_cast<int>(mapped_boxes.size()));
  row.emplace("trajectory", TrajectoryJson(map->trajectory));
  if (HasSurfaces(*truth)) {
    const std::vector<SurfaceFigures> surfaces = CompareObjectSurfaces(*map, *truth);
    Print(surfaces);
    row.emplace("surfaces", ToJson(surfaces));
  }
  all.pairs.emplace_back(std::move(row));
  return Ok();
}

std::string_view NameOf(shape::Symmetry symmetry) {
  switch (symmetry) {
    case shape::Symmetry::kHalf:
      return "half turn";
    case shape::Symmetry::kQuarter:
      return "quarter turn";
    case shape::Symmetry::kAny:
      return "any turn";
    case shape::Symmetry::kNone:
      break;
  }
  return "none";
}

eval::SetIou BestSet(const std::vector<ObjectScore>& objects,
                     std::vector<double> ObjectScore::*sweep) {
  std::vector<std::vector<double>> sweeps;
  for (const ObjectScore& object : objects) {
    if (object.has_shape) sweeps.push_back(object.*sweep);
  }
  return eval::BestOverSet(sweeps);
}

template <typename Value>
double MeanOf(const std::vector<ObjectScore>& objects, bool shapes_only, Value value) {
  double sum = 0;
  int count = 0;
  for (const ObjectScore& object : objects) {
    if (shapes_only && !object.has_shape) continue;
    sum += value(object);
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

JsonObject Summary(const Everything& all, const eval::SetIou& iou, const eval::SetIou& placed) {
  const std::vector<ObjectScore>& objects = all.objects;
  JsonObject row;
  row.emplace("num_true", static_cast<int>(all.true_boxes.size()));
  row.emplace("num_unseen", all.num_unseen);
  row.emplace("num_mapped", static_cast<int>(all.mapped_boxes.size()));
  row.emplace("num_matched", static_cast<int>(objects.size()));
  row.emplace("num_with_shape", static_cast<int>(iou.each.size()));
  row.emplace("iou", iou.mean);
  row.emplace("iou_threshold", iou.threshold);
  row.emplace("iou_as_placed", placed.mean);
  row.emplace("iou_as_placed_threshold", placed.threshold);
  row.emplace("chamfer", MeanOf(objects, true, [](const auto& o) { return o.chamfer; }));
  row.emplace("chamfer_as_placed",
              MeanOf(objects, true, [](const auto& o) { return o.chamfer_placed; }));
  row.emplace("in_place_iou", MeanOf(objects, false, [](const auto& o) { return o.in_place_iou; }));
  const auto num_correct = std::count_if(
      objects.begin(), objects.end(), [](const ObjectScore& o) { return o.placement.correct; });
  row.emplace("num_placed", static_cast<std::int64_t>(num_correct));
  row.emplace("placed_percent",
              all.true_boxes.empty() ? 0.0
                                     : 100.0 * static_cast<double>(num_correct) /
                                           static_cast<double>(all.true_boxes.size()));
  return row;
}

JsonArray ObjectRows(const Everything& all, const eval::SetIou& iou, const eval::SetIou& placed) {
  JsonArray rows;
  std::size_t shape = 0;
  for (const ObjectScore& object : all.objects) {
    JsonObject row;
    row.emplace("pair", static_cast<int>(object.pair));
    row.emplace("true_index", static_cast<int>(object.true_index));
    row.emplace("class", object.true_class);
    row.emplace("mapped", object.mapped_name);
    row.emplace("symmetry", NameOf(object.symmetry));
    row.emplace("translation_m", object.placement.translation_m);
    row.emplace("rotation_deg", object.placement.rotation_deg);
    row.emplace("scale_percent", object.placement.scale_percent);
    row.emplace("placed", object.placement.correct);
    row.emplace("in_place_iou", object.in_place_iou);
    if (object.has_shape) {
      row.emplace("iou", iou.each[shape]);
      row.emplace("iou_as_placed", placed.each[shape]);
      row.emplace("chamfer", object.chamfer);
      row.emplace("chamfer_as_placed", object.chamfer_placed);
      ++shape;
    }
    rows.emplace_back(std::move(row));
  }
  return rows;
}

JsonArray ClassRows(const Everything& all) {
  JsonArray rows;
  fmt::print(stderr,
             "{:<12} {:>5} {:>7} {:>6} {:>10} {:>7}\n",
             "class",
             "true",
             "mapped",
             "found",
             "precision",
             "recall");
  for (const eval::ClassCounts& counts :
       eval::CountByClass(all.mapped_boxes, all.true_boxes, all.matches)) {
    JsonObject row;
    row.emplace("class", counts.class_name);
    row.emplace("num_true", counts.num_true);
    row.emplace("num_mapped", counts.num_estimated);
    row.emplace("num_found", counts.num_found);
    row.emplace("precision", counts.precision());
    row.emplace("recall", counts.recall());
    rows.emplace_back(std::move(row));
    fmt::print(stderr,
               "{:<12} {:>5} {:>7} {:>6} {:>10.3f} {:>7.3f}\n",
               counts.class_name,
               counts.num_true,
               counts.num_estimated,
               counts.num_found,
               counts.precision(),
               counts.recall());
  }
  return rows;
}

JsonArray MistakenRows(const Everything& all) {
  JsonArray rows;
  for (const eval::Match& match : all.matches) {
    if (match.same_class) continue;
    JsonObject row;
    row.emplace("true_class", all.true_boxes[match.truth].class_name);
    row.emplace("mapped_class", all.mapped_boxes[match.estimated].class_name);
    row.emplace("distance_m", match.distance_m);
    rows.emplace_back(std::move(row));
  }
  return rows;
}

void PrintObjects(const Everything& all, const eval::SetIou& iou, const eval::SetIou& placed) {
  fmt::print(stderr,
             "{:<14} {:>7} {:>7} {:>7} {:>6} {:>7} {:>8} {:>7} {:>7}\n",
             "object",
             "IoU",
             "placed",
             "CD",
             "metric",
             "move cm",
             "turn deg",
             "size %",
             "placed");
  std::size_t shape = 0;
  for (const ObjectScore& object : all.objects) {
    const std::string shapes =
        object.has_shape
            ? fmt::format(
                  "{:>7.3f} {:>7.3f} {:>7.4f}", iou.each[shape], placed.each[shape], object.chamfer)
            : fmt::format("{:>7} {:>7} {:>7}", "-", "-", "-");
    shape += object.has_shape ? 1 : 0;
    fmt::print(stderr,
               "{:<14} {} {:>6.3f} {:>7.1f} {:>8.1f} {:>7.1f} {:>7}\n",
               object.mapped_name,
               shapes,
               object.in_place_iou,
               100 * object.placement.translation_m,
               object.placement.rotation_deg,
               object.placement.scale_percent,
               object.placement.correct ? "yes" : "no");
  }
}

int EvalObjects(const std::vector<std::string>& paths,
                const std::string& annotation,
                const std::string& json_file,
                const eval::PlacementOptions& options) {
  const Result<std::vector<EvalPair>> pairs = PairsOf(paths);
  if (!pairs.ok()) return ReportError(pairs.error());
  Everything all;
  for (const EvalPair& pair : *pairs) {
    if (Status status = AddPair(pair, annotation, options, all); !status.ok())
      return ReportError(status.error());
  }
  const eval::SetIou iou = BestSet(all.objects, &ObjectScore::iou_sweep);
  const eval::SetIou placed = BestSet(all.objects, &ObjectScore::iou_placed_sweep);
  JsonObject document = artifact::NewDocument("deepslam/eval_objects", 1);
  JsonObject protocols;
  protocols.emplace("iou", eval::kPix3dIou);
  protocols.emplace("chamfer", eval::kPix3dChamfer);
  protocols.emplace("placement", eval::kPlacementProtocol);
  protocols.emplace(
      "matching",
      fmt::format("nearest centres within {} m, one to one, pairs of one class first; "
                  "precision and recall by class",
                  options.max_match_m));
  protocols.emplace("boxes", eval::kBoxProtocol);
  protocols.emplace("surfaces",
                    fmt::format("{}; floor band {} m left out; of captures all of whose true "
                                "objects have shapes",
                                eval::kSurfaceProtocol,
                                kTrueFloorBandM));
  protocols.emplace("in_place_iou", "solids where they stand, 128 points along the longest side");
  protocols.emplace("symmetry", "best of the turns about the vertical that leave the true shape");
  document.emplace("protocols", std::move(protocols));
  document.emplace("classes", ClassRows(all));
  document.emplace("objects", ObjectRows(all, iou, placed));
  document.emplace("mistaken", MistakenRows(all));
  document.emplace("boxes", ToJson(all.boxes));
  PrintObjects(all, iou, placed);
  Print(all.boxes);
  JsonObject summary = Summary(all, iou, placed);
  if (!iou.each.empty()) {
    fmt::print(stderr,
               "mean IoU {:.4f} (as placed {:.4f}), CD {:.4f} over {} shapes; ",
               iou.mean,
               placed.mean,
               *summary.at("chamfer").As<double>(),
               iou.each.size());
  }
  fmt::print(stderr,
             "placed {} of {} true objects\n",
             *summary.at("num_placed").As<std::int64_t>(),
             all.true_boxes.size());
  document.emplace("summary", std::move(summary));
  document.emplace("pairs", std::move(all.pairs));
  const Result<std::string> text = DumpJson(std::move(document), "objects");
  const Status status = text.ok() ? WriteResult(json_file, *text) : Status(text.error());
  return status.ok() ? kExitOk : ReportError(status.error());
}

}  // namespace

void AddEvalObjects(CLI::App& eval_command, Command& chosen) {
  struct Arguments {
    std::vector<std::string> paths;
    std::string annotation;
    std::string json;
    eval::PlacementOptions options;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = eval_command.add_subcommand(
      "objects", "Mapped objects against the true ones: found, shape, placement");
  command
      ->add_option("PATHS",
                   arguments->paths,
                   "WORKSPACE TRUTH, or several such pairs that are scored as one set; TRUTH is a "
                   "capture with groundtruth.txt and truth/objects.json or objects.json")
      ->required();
  command->add_option("--annotation", arguments->annotation, "Annotation file in place of TRUTH's");
  command->add_option(
      "--json", arguments->json, "Write the result here instead of to standard output");
  command
      ->add_option("--max-match",
                   arguments->options.max_match_m,
                   "Between the centres of a true object and its mapped one, m")
      ->check(NumberFrom(0.01, 100.0))
      ->capture_default_str();
  command->callback([&chosen, arguments] {
    chosen = [arguments] {
      return EvalObjects(
          arguments->paths, arguments->annotation, arguments->json, arguments->options);
    };
  });
}

}  // namespace deepslam::tools
