// `deepslam eval trajectory`: camera poses against the true ones.
#include <filesystem>
#include <memory>
#include <string_view>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "deepslam/artifact/json_reader.h"
#include "deepslam/geometry/trajectory_error.h"
#include "deepslam/layouts/open_capture.h"
#include "eval_commands.h"
#include "eval_data.h"
#include "number_from.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;
using artifact::JsonObject;
using artifact::JsonValue;

// Those that came with a capture of a layout other than TUM's.
Result<std::vector<TimedPose>> CapturePoses(const std::string& path) {
  const Result<dataset::Capture> capture = layouts::OpenCapture(path, layouts::FramesTaken::kAll);
  if (!capture.ok() || !capture->has_poses) {
    return InvalidInput(
        fmt::format("{}: holds no trajectory: neither a workspace nor a capture with poses", path));
  }
  std::vector<TimedPose> poses;
  for (const dataset::StoredFrame& frame : capture->stored->frames()) {
    if (frame.world_from_colour) poses.push_back({frame.depth_time_s, *frame.world_from_colour});
  }
  return poses;
}

using PoseReader = Result<std::vector<TimedPose>> (*)(const fs::path& file);

// Poses of a workspace (the final ones), those that came with a capture, or of a TUM file, read by
// `read_file`.
Result<std::vector<TimedPose>> ReadPoses(const fs::path& path, PoseReader read_file) {
  std::error_code error;
  if (!fs::is_directory(path, error))
    return path.extension() == ".sens" ? CapturePoses(path) : read_file(path);
  for (const char* stage : {"optimize", "track"}) {
    const fs::path file = path / stage / "trajectory.tum";
    if (fs::exists(file, error)) return ReadTum(file);
  }
  const fs::path file = path / "groundtruth.txt";
  return fs::exists(file, error) ? ReadCaptureTum(file) : CapturePoses(path);
}

JsonValue ToJson(const ErrorStatistics& statistics) {
  JsonObject row;
  row.emplace("rmse", statistics.rmse);
  row.emplace("mean", statistics.mean);
  row.emplace("median", statistics.median);
  row.emplace("max", statistics.max);
  return JsonValue(std::move(row));
}

void PrintRow(std::string_view name, const ErrorStatistics& statistics) {
  fmt::print(stderr,
             "{:<12} {:>10.6f} {:>10.6f} {:>10.6f} {:>10.6f}\n",
             name,
             statistics.rmse,
             statistics.mean,
             statistics.median,
             statistics.max);
}

struct EvalTrajectoryArguments {
  std::string estimate;
  std::string truth;
  std::string json;
  TrajectoryErrorOptions options;
};

int EvalTrajectory(const EvalTrajectoryArguments& arguments) {
  const Result<std::vector<TimedPose>> estimated = ReadPoses(arguments.estimate, ReadTum);
  if (!estimated.ok()) return ReportError(estimated.error());
  const Result<std::vector<TimedPose>> true_poses = ReadPoses(arguments.truth, ReadCaptureTum);
  if (!true_poses.ok()) return ReportError(true_poses.error());
  const Result<TrajectoryError> result =
      ComputeTrajectoryError(*estimated, *true_poses, arguments.options);
  if (!result.ok()) {
    return ReportError(InvalidInput(
        fmt::format("{} and {}: {}", arguments.estimate, arguments.truth, result.error().message)));
  }
  if (result->num_relative == 0 && arguments.options.rpe_delta > 1) {
    return ReportError(InvalidInput(fmt::format("--rpe-delta {}: only {} frames were scored",
                                                arguments.options.rpe_delta,
                                                result->num_scored)));
  }
  fmt::print(
      stderr, "{:<12} {:>10} {:>10} {:>10} {:>10}\n", "error", "rmse", "mean", "median", "max");
  PrintRow("ATE m", result->ate_m);
  PrintRow("RPE m", result->rpe_m);
  PrintRow("RPE deg", result->rpe_deg);
  fmt::print(stderr,
             "{} of {} frames scored, {} relative poses\n",
             result->num_scored,
             result->num_frames,
             result->num_relative);
  JsonObject document = artifact::NewDocument("deepslam/trajectory_error", 1);
  document.emplace("protocol",
                   fmt::format("{}; pairs within {} s; relative poses over {} scored frames",
                               kTrajectoryProtocol,
                               arguments.options.max_time_difference_s,
                               arguments.options.rpe_delta));
  document.emplace("num_frames", result->num_frames);
  document.emplace("num_scored", result->num_scored);
  document.emplace("num_relative", result->num_relative);
  document.emplace("ate_m", ToJson(result->ate_m));
  document.emplace("rpe_m", ToJson(result->rpe_m));
  document.emplace("rpe_deg", ToJson(result->rpe_deg));
  const Result<std::string> text = DumpJson(std::move(document), "trajectory error");
  const Status status = text.ok() ? WriteResult(arguments.json, *text) : Status(text.error());
  return status.ok() ? kExitOk : ReportError(status.error());
}

}  // namespace

void AddEvalTrajectory(CLI::App& eval_command, Command& chosen) {
  auto arguments = std::make_shared<EvalTrajectoryArguments>();
  CLI::App* command = eval_command.add_subcommand("trajectory", "ATE and RPE of camera poses");
  command->add_option("ESTIMATE", arguments->estimate, "Workspace, or TUM file")->required();
  command->add_option("TRUTH", arguments->truth, "Capture with poses, or TUM file")->required();
  command->add_option(
      "--json", arguments->json, "Write the result here instead of to standard output");
  command
      ->add_option("--max-time-difference",
                   arguments->options.max_time_difference_s,
                   "Between an estimated pose and its true one, s")
      ->check(NumberFrom(0.0, 10.0))
      ->capture_default_str();
  command
      ->add_option(
          "--rpe-delta", arguments->options.rpe_delta, "Frames between the ends of a relative pose")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command->callback(
      [&chosen, arguments] { chosen = [arguments] { return EvalTrajectory(*arguments); }; });
}

}  // namespace deepslam::tools
