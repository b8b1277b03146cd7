// `deepslam eval layout`: walls, rooms and openings against the true ones.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "deepslam/artifact/coarse_surface_file.h"
#include "deepslam/artifact/ground_json.h"
#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/layout_json.h"
#include "deepslam/artifact/ply.h"
#include "deepslam/artifact/trajectory_files.h"
#include "deepslam/eval/layout_score.h"
#include "deepslam/storage/store.h"
#include "eval_commands.h"
#include "eval_data.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;
using artifact::JsonArray;
using artifact::JsonNode;
using artifact::JsonObject;
using artifact::JsonReader;
using artifact::JsonValue;

constexpr double kMaxPlace_m = 1000;  // files with coordinates beyond are refused: not in metres

// What a workspace says, in the true world.
struct EstimatedLayout {
  Layout layout;
  std::vector<Eigen::Vector3d> surface;
};

// A place on the ground; the worlds differ by a turn about the vertical and what tracking is off.
Eigen::Vector2d OnGround(const Pose3& truth_from_level, const Eigen::Vector2d& p) {
  return (truth_from_level * Eigen::Vector3d(p.x(), p.y(), 0)).head<2>();
}

void MoveTo(const Pose3& truth_from_level, Layout& layout) {
  const double up_m = truth_from_level.translation_m.z();
  for (LayoutRoom& room : layout.rooms) {
    for (Eigen::Vector2d& corner : room.polygon_m) corner = OnGround(truth_from_level, corner);
  }
  const auto move = [&](auto& part) {
    part.from_m = OnGround(truth_from_level, part.from_m);
    part.to_m = OnGround(truth_from_level, part.to_m);
    part.bottom_m += up_m;
    part.top_m += up_m;
  };
  std::for_each(layout.walls.begin(), layout.walls.end(), move);
  std::for_each(layout.openings.begin(), layout.openings.end(), move);
}

// Of frames whose place tracking registered to the first: the layout is seen from these, and
// what stands apart would turn the one world against the other.
Result<std::vector<TimedPose>> ReadJoinedPoses(const fs::path& workspace) {
  const fs::path frames_file = workspace / "track" / "frames.json";
  const Result<std::string> frames = storage::ReadFile(frames_file);
  if (!frames.ok()) return frames.error();
  const Result<std::string> tum = storage::ReadFile(workspace / "track" / "trajectory.tum");
  if (!tum.ok()) return tum.error();
  const auto trajectory = artifact::DecodeTrajectory(*frames, *tum, frames_file.string());
  if (!trajectory.ok()) return trajectory.error();
  const fs::path ground_file = workspace / "ground" / "ground.json";
  const Result<std::string> text = storage::ReadFile(ground_file);
  if (!text.ok()) return text.error();
  const Result<Ground> ground = artifact::DecodeGround(*text, ground_file.string());
  if (!ground.ok()) return ground.error();
  std::vector<TimedPose> poses;
  for (const TrackedFrame& frame : trajectory->frames) {
    if (IsAligned(frame) && ApartAt(*ground, frame.frame) == nullptr)
      poses.push_back({frame.time_s, frame.world_from_camera});
  }
  return poses;
}

Result<EstimatedLayout> ReadEstimate(const fs::path& workspace, const Truth& truth) {
  const auto poses = ReadJoinedPoses(workspace);
  if (!poses.ok()) return poses.error();
  const auto error = ComputeTrajectoryError(*poses, truth.poses, TrajectoryErrorOptions());
  if (!error.ok()) {
    return InvalidInput(fmt::format("{} and {}: cannot be aligned: {}",
                                    workspace.string(),
                                    (truth.capture / "groundtruth.txt").string(),
                                    error.error().message));
  }
  const fs::path file = workspace / "layout" / "layout.json";
  const Result<std::string> text = storage::ReadFile(file);
  if (!text.ok()) return text.error();
  Result<Layout> layout = artifact::DecodeLayout(*text, file.string());
  if (!layout.ok()) return layout.error();
  const Result<TriangleMesh> mesh = ReadPlyMesh(workspace / "layout" / "surface.ply");
  if (!mesh.ok()) return mesh.error();
  const Pose3 truth_from_level = error->truth_from_estimate * layout->level_from_tracking.Inverse();
  EstimatedLayout estimate;
  estimate.layout = std::move(layout).value();
  MoveTo(truth_from_level, estimate.layout);
  for (const Eigen::Vector3f& p : mesh->vertices)
    estimate.surface.push_back(truth_from_level * p.cast<double>());
  return estimate;
}

eval::TrueLayout TruthOf(const Layout& layout) {
  eval::TrueLayout truth;
  for (const LayoutRoom& room : layout.rooms) truth.rooms.push_back(room.polygon_m);
  for (const LayoutWall& wall : layout.walls)
    truth.walls.push_back({wall.from_m, wall.to_m, 0, wall.bottom_m, wall.top_m});
  for (const LayoutOpening& opening : layout.openings) {
    truth.openings.push_back(
        {opening.kind, opening.from_m, opening.to_m, 0, opening.bottom_m, opening.top_m});
  }
  return truth;
}

// The middle line of a box along its longer side, and its width across.
template <typename Part>
void SetBox(const JsonNode& node, Part& part) {
  const auto numbers = [](const JsonNode& row) {
    Eigen::Vector3d value;
    const std::vector<JsonNode> items = row.Items(3);
    for (std::size_t n = 0; n < 3; ++n)
      value[static_cast<Eigen::Index>(n)] = items[n].Number(-kMaxPlace_m, kMaxPlace_m);
    return value;
  };
  const Eigen::Vector3d centre = numbers(node["center_m"]);
  const Eigen::Vector3d half = numbers(node["half_extent_m"]).cwiseAbs();
  const double yaw_rad = node["yaw_rad"].Number(-10, 10);
  const Eigen::Vector2d x(std::cos(yaw_rad), std::sin(yaw_rad));
  const Eigen::Vector2d along = half.x() > half.y() ? x : Eigen::Vector2d(-x.y(), x.x());
  const double half_length_m = std::max(half.x(), half.y());
  part.from_m = centre.head<2>() - half_length_m * along;
  part.to_m = centre.head<2>() + half_length_m * along;
  part.thickness_m = 2 * std::min(half.x(), half.y());
  part.bottom_m = centre.z() - half.z();
  part.top_m = centre.z() + half.z();
}

// structure.json: boxes of walls, doors and windows.
Result<eval::TrueLayout> ReadStructure(const fs::path& file) {
  const Result<std::string> text = storage::ReadFile(file);
  if (!text.ok()) return text.error();
  JsonReader reader(*text, file.string(), "", 0);
  eval::TrueLayout truth;
  for (const JsonNode& node : reader.root()["objects"].Items()) {
    const std::string name = node["class"].String();
    if (name == "wall") {
      SetBox(node, truth.walls.emplace_back());
    } else if (name == "door" || name == "window") {
      SetBox(node, truth.openings.emplace_back());
      truth.openings.back().kind = name == "door" ? OpeningKind::kDoor : OpeningKind::kWindow;
    }
  }
  return reader.Finish(std::move(truth));
}

Result<eval::TrueLayout> ReadTrueLayout(const fs::path& capture, const std::string& annotation) {
  std::error_code code;
  if (!annotation.empty()) return ReadStructure(annotation);
  if (const fs::path file = capture / "truth" / "layout.json"; fs::exists(file, code)) {
    const Result<std::string> text = storage::ReadFile(file);
    if (!text.ok()) return text.error();
    const Result<Layout> layout = artifact::DecodeLayout(*text, file.string());
    if (!layout.ok()) return layout.error();
    return TruthOf(*layout);
  }
  if (const fs::path file = capture / "structure.json"; fs::exists(file, code))
    return ReadStructure(file);
  return InvalidInput(capture.string() +
                      ": no true layout there, neither truth/layout.json nor structure.json; name "
                      "a file of boxes with --annotation");
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

JsonValue Numbers(const std::vector<int>& values) {
  JsonArray array;
  for (const int value : values) array.emplace_back(value);
  return JsonValue(std::move(array));
}

JsonObject LayoutScoreJson(const eval::LayoutScore& score) {
  JsonObject row;
  row.emplace("num_true_walls", score.num_true_walls);
  row.emplace("num_walls", score.num_walls);
  row.emplace("wall_recall", score.wall_recall());
  row.emplace("wall_precision", score.wall_precision());
  row.emplace("missed_walls", Numbers(score.missed_walls));
  row.emplace("wrong_walls", Numbers(score.wrong_walls));
  row.emplace("num_corners", static_cast<std::int64_t>(score.corner_m.size()));
  row.emplace("corner_median_m", Median(score.corner_m));
  row.emplace("num_true_rooms", score.num_true_rooms);
  row.emplace("num_found_rooms", static_cast<std::int64_t>(score.room_area_error.size()));
  row.emplace("room_area_error_median", Median(score.room_area_error));
  JsonArray kinds;
  for (const eval::KindScore& kind : score.openings) {
    JsonObject of;
    of.emplace("kind", NameOf(kind.kind));
    of.emplace("num_true", kind.num_true);
    of.emplace("num_estimated", kind.num_estimated);
    of.emplace("precision", kind.precision());
    of.emplace("recall", kind.recall());
    of.emplace("f1", kind.f1());
    kinds.emplace_back(std::move(of));
  }
  row.emplace("openings", std::move(kinds));
  row.emplace("num_openings_found_as_any_kind", score.num_openings_any_kind);
  return row;
}

void Print(const std::string& name, const eval::LayoutScore& score) {
  fmt::print(stderr,
             "{}\n  walls: {} of {} found, {} of {} right; recall {:.3f}, precision {:.3f}\n",
             name,
             score.num_found_walls,
             score.num_true_walls,
             score.num_right_walls,
             score.num_walls,
             score.wall_recall(),
             score.wall_precision());
  if (!score.corner_m.empty()) {
    fmt::print(stderr,
               "  corners: median {:.3f} m of {}; rooms: {} of {} found, area off by {:.1f} %\n",
               Median(score.corner_m),
               score.corner_m.size(),
               score.room_area_error.size(),
               score.num_true_rooms,
               100 * Median(score.room_area_error));
  }
  for (const eval::KindScore& kind : score.openings) {
    if (kind.num_true + kind.num_estimated == 0) continue;
    fmt::print(stderr,
               "  {}s: {} true, {} told, {} found; recall {:.3f}, precision {:.3f}, F1 {:.3f}\n",
               NameOf(kind.kind),
               kind.num_true,
               kind.num_estimated,
               kind.num_found,
               kind.recall(),
               kind.precision(),
               kind.f1());
  }
}

struct EvalLayoutArguments {
  std::vector<std::string> paths;
  std::string annotation;
  std::string json;
};

int EvalLayout(const EvalLayoutArguments& arguments) {
  const Result<std::vector<EvalPair>> pairs = PairsOf(arguments.paths);
  if (!pairs.ok()) return ReportError(pairs.error());
  JsonArray rows;
  for (const EvalPair& pair : *pairs) {
    const Result<Truth> truth = ReadTruth(pair.truth, "", false);
    if (!truth.ok()) return ReportError(truth.error());
    const Result<eval::TrueLayout> layout = ReadTrueLayout(pair.truth, arguments.annotation);
    if (!layout.ok()) return ReportError(layout.error());
    const Result<EstimatedLayout> estimate = ReadEstimate(pair.workspace, *truth);
    if (!estimate.ok()) return ReportError(estimate.error());
    const eval::LayoutScore score =
        eval::ScoreLayout(estimate->layout, *layout, estimate->surface, eval::LayoutScoreOptions());
    Print(pair.workspace.string(), score);
    JsonObject row = LayoutScoreJson(score);
    row.emplace("workspace", pair.workspace.string());
    rows.emplace_back(std::move(row));
  }
  JsonObject document = artifact::NewDocument("deepslam/eval_layout", 1);
  document.emplace("protocol", eval::kLayoutProtocol);
  document.emplace("pairs", std::move(rows));
  const Result<std::string> text = DumpJson(std::move(document), "layout");
  const Status status = text.ok() ? WriteResult(arguments.json, *text) : Status(text.error());
  return status.ok() ? kExitOk : ReportError(status.error());
}

}  // namespace

void AddEvalLayout(CLI::App& eval_command, Command& chosen) {
  auto arguments = std::make_shared<EvalLayoutArguments>();
  CLI::App* command = eval_command.add_subcommand(
      "layout", "Walls, corners, rooms and openings against the true ones");
  command
      ->add_option(
          "PATHS",
          arguments->paths,
          "WORKSPACE TRUTH, or several such pairs; TRUTH is a capture with groundtruth.txt "
          "and truth/layout.json, or structure.json with boxes of walls, doors, windows")
      ->required();
  command->add_option(
      "--annotation", arguments->annotation, "File of boxes in place of TRUTH's own");
  command->add_option(
      "--json", arguments->json, "Write the result here instead of to standard output");
  command->callback(
      [&chosen, arguments] { chosen = [arguments] { return EvalLayout(*arguments); }; });
}

}  // namespace deepslam::tools
