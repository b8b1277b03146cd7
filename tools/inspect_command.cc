#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "commands.h"
#include "console.h"
#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/json_value.h"
#include "deepslam/artifact/store.h"
#include "deepslam/artifact/trajectory_files.h"
#include "deepslam/dataset/capture.h"
#include "deepslam/eval/trajectory_error.h"
#include "deepslam/gltf/validate.h"
#include "eval_commands.h"
#include "eval_silhouettes.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;
using artifact::JsonArray;
using artifact::JsonObject;
using artifact::JsonValue;

JsonValue Strings(const std::vector<std::string>& strings) {
  JsonArray array;
  for (const std::string& string : strings) array.emplace_back(string);
  return JsonValue(std::move(array));
}

JsonValue ToJson(const gltf::ValidationReport& report) {
  JsonObject document = artifact::NewDocument("deepslam/validation", 1);
  document.emplace("ok", report.ok());
  document.emplace("errors", Strings(report.errors));
  document.emplace("warnings", Strings(report.warnings));
  document.emplace("num_objects", report.num_objects);
  document.emplace("num_nodes", report.num_nodes);
  document.emplace("num_meshes", report.num_meshes);
  document.emplace("num_vertices", report.num_vertices);
  document.emplace("num_faces", report.num_faces);
  document.emplace("num_bytes", static_cast<std::int64_t>(report.num_bytes));
  document.emplace("draco", report.draco);
  document.emplace("has_ground", report.has_ground);
  document.emplace("has_room", report.has_room);
  document.emplace("has_trajectory", report.has_trajectory);
  JsonArray objects;
  for (const gltf::ValidatedObject& object : report.objects) {
    JsonObject row;
    row.emplace("name", object.name);
    row.emplace("class", object.class_name);
    row.emplace("instance", object.instance);
    row.emplace("num_faces", object.num_faces);
    row.emplace("num_components", object.num_components);
    row.emplace("volume_m3", object.volume_m3);
    row.emplace("closed", object.closed);
    row.emplace("two_manifold", object.two_manifold);
    objects.emplace_back(std::move(row));
  }
  document.emplace("objects", std::move(objects));
  return JsonValue(std::move(document));
}

int Validate(const std::string& file, const std::string& json_file) {
  const Result<std::string> bytes = artifact::ReadFile(file);
  if (!bytes.ok()) return ReportError(bytes.error());
  const gltf::ValidationReport report = gltf::ValidateGlb(*bytes);
  for (const std::string& warning : report.warnings)
    LogWarning(fmt::format("{}: {}", file, warning));
  for (const std::string& error : report.errors) LogError(fmt::format("{}: {}", file, error));
  const Result<std::string> text = DumpJson(ToJson(report), "validation");
  if (Status status = text.ok() ? WriteResult(json_file, *text) : Status(text.error());
      !status.ok()) {
    return ReportError(status.error());
  }
  return report.ok() ? kExitOk : kExitFailed;
}

// Poses of a TUM file, of a workspace (the final ones), or those that came with a capture.
Result<std::vector<eval::TimedPose>> ReadPoses(const std::string& path) {
  std::error_code error;
  fs::path file = path;
  if (fs::is_directory(path, error)) {
    file = fs::path(path) / "optimize" / "trajectory.tum";
    if (!fs::exists(file, error)) file = fs::path(path) / "track" / "trajectory.tum";
    if (!fs::exists(file, error)) file = fs::path(path) / "groundtruth.txt";
    if (!fs::exists(file, error)) {
      return InvalidInput(fmt::format(
          "{}: holds no trajectory: neither a workspace nor a capture with poses", path));
    }
  }
  const Result<std::string> text = artifact::ReadFile(file);
  if (!text.ok()) return text.error();
  const auto decoded = artifact::DecodeTum(*text, file.string());
  if (!decoded.ok()) return decoded.error();
  std::vector<eval::TimedPose> poses;
  for (const artifact::StampedPose& pose : *decoded)
    poses.push_back({pose.time_s, pose.world_from_camera});
  return poses;
}

JsonValue ToJson(const eval::ErrorStatistics& statistics) {
  JsonObject row;
  row.emplace("rmse", statistics.rmse);
  row.emplace("mean", statistics.mean);
  row.emplace("median", statistics.median);
  row.emplace("max", statistics.max);
  return JsonValue(std::move(row));
}

int EvalTrajectory(const std::string& estimate,
                   const std::string& truth,
                   const std::string& json_file,
                   const eval::TrajectoryErrorOptions& options) {
  const Result<std::vector<eval::TimedPose>> estimated = ReadPoses(estimate);
  if (!estimated.ok()) return ReportError(estimated.error());
  const Result<std::vector<eval::TimedPose>> true_poses = ReadPoses(truth);
  if (!true_poses.ok()) return ReportError(true_poses.error());
  const Result<eval::TrajectoryError> result =
      eval::ComputeTrajectoryError(*estimated, *true_poses, options);
  if (!result.ok()) return ReportError(result.error());
  LogInfo(fmt::format(
      "ATE rmse {:.4f} m, max {:.4f} m; RPE rmse {:.4f} m, {:.3f} deg; {} of {} frames scored",
      result->ate_m.rmse,
      result->ate_m.max,
      result->rpe_m.rmse,
      result->rpe_deg.rmse,
      result->num_scored,
      result->num_frames));
  JsonObject document = artifact::NewDocument("deepslam/trajectory_error", 1);
  document.emplace("num_frames", result->num_frames);
  document.emplace("num_scored", result->num_scored);
  document.emplace("num_relative", result->num_relative);
  document.emplace("ate_m", ToJson(result->ate_m));
  document.emplace("rpe_m", ToJson(result->rpe_m));
  document.emplace("rpe_deg", ToJson(result->rpe_deg));
  const Result<std::string> text = DumpJson(std::move(document), "trajectory error");
  const Status status = text.ok() ? WriteResult(json_file, *text) : Status(text.error());
  return status.ok() ? kExitOk : ReportError(status.error());
}

}  // namespace

void AddValidate(CLI::App& app, Command& chosen) {
  struct Arguments {
    std::string file;
    std::string json;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* validate = app.add_subcommand(
      "validate", "Check a scene file: reread, decode, bounds, closedness, labels");
  validate->add_option("SCENE", arguments->file, "A .glb file")->required();
  validate->add_option(
      "--json", arguments->json, "Write the result here instead of to standard output");
  validate->callback([&chosen, arguments] {
    chosen = [arguments] { return Validate(arguments->file, arguments->json); };
  });
}

namespace {

void AddEvalSilhouettes(CLI::App& eval_command, Command& chosen) {
  struct Arguments {
    std::string workspace;
    std::string capture;
    std::string json;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* silhouettes = eval_command.add_subcommand(
      "silhouettes", "Overlap of the projected objects with what was segmented; needs no truth");
  silhouettes->add_option("WORKSPACE", arguments->workspace, "Workspace of a finished run")
      ->required();
  silhouettes->add_option("CAPTURE", arguments->capture, "The capture it was made of")->required();
  silhouettes->add_option(
      "--json", arguments->json, "Write the result here instead of to standard output");
  silhouettes->callback([&chosen, arguments] {
    chosen = [arguments] {
      return EvalSilhouettes(arguments->workspace, arguments->capture, arguments->json);
    };
  });
}

}  // namespace

void AddEval(CLI::App& app, Command& chosen) {
  struct Arguments {
    std::string estimate;
    std::string truth;
    std::string json;
    eval::TrajectoryErrorOptions options;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* eval_command = app.add_subcommand("eval", "Compare results with the truth");
  eval_command->require_subcommand(1);
  AddEvalObjects(*eval_command, chosen);
  AddEvalSelection(*eval_command, chosen);
  AddEvalMap(*eval_command, chosen);
  CLI::App* trajectory = eval_command->add_subcommand("trajectory", "ATE and RPE of camera poses");
  trajectory->add_option("ESTIMATE", arguments->estimate, "Workspace, or TUM file")->required();
  trajectory->add_option("TRUTH", arguments->truth, "Capture with poses, or TUM file")->required();
  trajectory->add_option(
      "--json", arguments->json, "Write the result here instead of to standard output");
  trajectory
      ->add_option("--max-time-difference",
                   arguments->options.max_time_difference_s,
                   "Between an estimated pose and its true one, s")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  trajectory
      ->add_option(
          "--rpe-delta", arguments->options.rpe_delta, "Frames between the ends of a relative pose")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  trajectory->callback([&chosen, arguments] {
    chosen = [arguments] {
      return EvalTrajectory(
          arguments->estimate, arguments->truth, arguments->json, arguments->options);
    };
  });
  AddEvalSilhouettes(*eval_command, chosen);
}

}  // namespace deepslam::tools
