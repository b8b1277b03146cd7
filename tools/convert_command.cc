#include <unistd.h>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "commands.h"
#include "console.h"
#include "deepslam/convert/convert.h"
#include "deepslam/convert/posed_frames.h"
#include "deepslam/layouts/open_capture.h"
#include "number_from.h"

namespace deepslam::tools {
namespace {

struct ConvertArguments {
  std::string in;
  std::string out;
  std::string to;
  double depth_units_per_m = 0;
  std::string trajectory;
  std::string progress = "auto";
};

int Convert(const ConvertArguments& arguments) {
  if (arguments.out.empty())
    return ReportError(InvalidConfig("OUT: names no folder or file; give the result's"));
  const convert::OutputFormat* format = convert::FindOutputFormat(arguments.to);
  CatchStopSignals();
  Result<dataset::Capture> capture = layouts::OpenCapture(arguments.in, layouts::FramesTaken::kAll);
  if (!capture.ok()) return ReportError(capture.error());
  if (!arguments.trajectory.empty()) {
    if (Status taken = convert::TakePosesOf(arguments.trajectory, *capture); !taken.ok())
      return ReportError(taken.error());
  }
  for (const std::string& warning : capture->warnings) LogWarning(warning);
  ConsoleListener listener(ParseProgressStyle(arguments.progress), false);
  listener.StageStarts("convert", {});
  const Result<convert::ConversionReport> report =
      convert::ConvertCapture(*capture,
                              arguments.out,
                              *format,
                              arguments.depth_units_per_m,
                              [&](std::size_t done, std::size_t total) {
                                listener.Report(done, total);
                                return !StopSignalled();
                              });
  listener.EndProgress();
  if (!report.ok()) return ReportError(report.error());
  LogInfo(fmt::format("{}: {} frames, {} poses, {} -> {}",
                      arguments.out,
                      report->num_frames,
                      report->num_poses,
                      report->from,
                      report->to));
  for (const std::string& note : report->notes) LogInfo(note);
  for (const std::string& loss : report->losses) LogWarning("lost: " + loss);
  if (report->losses.empty()) LogInfo("nothing is lost");
  if (::isatty(STDOUT_FILENO) != 0) return kExitOk;
  const Status status = WriteResult("", convert::FormatReport(*report));
  return status.ok() ? kExitOk : ReportError(status.error());
}

}  // namespace

void AddConvert(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<ConvertArguments>();
  CLI::App* convert = app.add_subcommand(
      "convert", "A capture in the layout of another program; says what that layout cannot hold");
  convert->add_option("IN", arguments->in, "Capture in any layout (docs/formats.md)")->required();
  convert->add_option("OUT", arguments->out, "Folder to write; for scannet a file NAME.sens")
      ->required();
  std::vector<std::string> names;
  for (const convert::OutputFormat& format : convert::OutputFormats())
    names.emplace_back(format.name);
  convert
      ->add_option("--to",
                   arguments->to,
                   "Layout to write: tum, 7scenes, scannet, open3d, nerfstudio or colmap")
      ->required()
      ->check(CLI::IsMember(names));
  convert
      ->add_option("--depth-units",
                   arguments->depth_units_per_m,
                   "Raw depth of one metre in the result, 1/m; default: the source's where the "
                   "layout can hold it")
      ->check(NumberFrom(1.0, 1e6));
  convert->add_option("--trajectory",
                      arguments->trajectory,
                      "Poses to write instead of the capture's: the folder of a run, or a list "
                      "'time tx ty tz qx qy qz qw'");
  convert->add_option("--progress", arguments->progress, "auto, bar, json or none")
      ->check(CLI::IsMember({"auto", "bar", "json", "none"}))
      ->capture_default_str();
  convert->callback([&chosen, arguments] { chosen = [arguments] { return Convert(*arguments); }; });
}

}  // namespace deepslam::tools
