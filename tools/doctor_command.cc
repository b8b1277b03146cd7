#include <sys/statvfs.h>

#include <unistd.h>
#include <algorithm>
#include <cstdint>
#include <memory>
#include <thread>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "commands.h"
#include "console.h"
#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/json_value.h"
#include "deepslam/batch/forecast.h"
#include "deepslam/layouts/open_capture.h"
#include "deepslam/layouts/suggest_settings.h"
#include "deepslam/library/furniture_library.h"
#include "deepslam/stages/data_folder.h"
#include "deepslam/stages/model_cache.h"
#include "deepslam/stages/plan.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;
using artifact::JsonArray;
using artifact::JsonObject;

// What a run was measured to take per frame of 640 x 480 on two cores; for the forecast alone.
constexpr double kSecondsPerFrame = 0.06;
constexpr double kBaseSeconds = 10;  // of any run, however short
constexpr double kMemoryMib = 600;   // twice of it is asked for

// A finding: what was looked at, whether it is well, and what to do if not.
struct Finding {
  std::string what;
  bool ok = true;
  std::string detail;
};

Finding CheckWeights(const fs::path& data_folder, const stages::Config& config) {
  if (config.detect_stage.source != "network")
    return {"detector weights", true, "not needed: " + config.detect_stage.source};
  const Result<fs::path> file = stages::FindWeights(data_folder, config.detect_stage.weights);
  if (!file.ok()) return {"detector weights", false, file.error().message};
  std::string others;
  std::error_code ignored;
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(data_folder / "weights", ignored)) {
    if (entry.path().extension() == ".onnx") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  for (const std::string& name : names) others += " " + name;
  return {"detector weights", true, fmt::format("{} (there are:{})", file->string(), others)};
}

Finding CheckLibrary(const fs::path& data_folder, const stages::Config& config) {
  if (!config.propose_stage.retrieval)
    return {"furniture library", true, "not needed: propose.retrieval is false"};
  const Result<fs::path> folder = stages::FindLibrary(data_folder, config.propose_stage.library);
  if (!folder.ok()) return {"furniture library", false, folder.error().message};
  const Result<ModelLibrary> library = library::LoadLibrary(*folder);
  if (!library.ok()) return {"furniture library", false, library.error().message};
  return {"furniture library",
          true,
          fmt::format("{} models in {}", library->models.size(), folder->string())};
}

Finding CheckNetworks(const fs::path& data_folder,
                      const stages::Config& config,
                      const ClassTable& classes) {
  const std::string what = "shape networks";
  if (!config.propose_stage.network) return {what, true, "not needed: propose.network is false"};
  const auto folder = stages::FindPriors(data_folder, config.propose_stage.priors);
  if (!folder.ok()) return {what, false, folder.error().message};
  if (!folder->has_value())
    return {what, false, "none came with the program; make them by scripts/train/train.sh CLASS"};
  const auto priors =
      stages::FindShapePriors({data_folder, {}}, config.propose_stage.priors, classes);
  if (!priors.ok()) return {what, false, priors.error().message};
  std::string names;
  for (const auto& [class_name, prior] : **priors) names += " " + class_name;
  return {what, true, fmt::format("of{} in {}", names, (*folder)->string())};
}

std::string CpuFeatures() {
  __builtin_cpu_init();
  std::string features;
  if (__builtin_cpu_supports("sse4.2")) features += " sse4.2";
  if (__builtin_cpu_supports("avx")) features += " avx";
  if (__builtin_cpu_supports("avx2")) features += " avx2";
  if (__builtin_cpu_supports("fma")) features += " fma";
  if (__builtin_cpu_supports("avx512f")) features += " avx512f";
  return features.empty() ? " none beyond x86-64" : features;
}

Finding CheckMemory() {
  const double bytes = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) *
                       static_cast<double>(::sysconf(_SC_PAGE_SIZE));
  const double mib = bytes / (1024.0 * 1024.0);
  return {"memory",
          mib > 2 * kMemoryMib,
          fmt::format("{:.0f} MiB; a run takes about {:.0f} MiB", mib, kMemoryMib)};
}

Finding CheckDisk() {
  struct statvfs status {};
  if (::statvfs(".", &status) != 0)
    return {"disk", false, "the current folder's file system cannot be asked"};
  const double free_bytes =
      static_cast<double>(status.f_bavail) * static_cast<double>(status.f_frsize);
  return {"disk",
          free_bytes > 1e9,
          fmt::format("{:.1f} GB free in the current folder", free_bytes / 1e9)};
}

// How depth gets to the colour camera, where it is not there from the beginning.
std::string Registration(const dataset::Capture& capture) {
  const dataset::CaptureCameras& cameras = capture.stored->cameras();
  if (cameras.registered()) return "";
  return fmt::format(" (colour {} x {}, depth {} x {} {} it)",
                     cameras.colour.width,
                     cameras.colour.height,
                     cameras.depth.width,
                     cameras.depth.height,
                     cameras.colour_from_depth == Pose3() ? "resampled to" : "registered to");
}

// Which --poses fits: those of a recorder help tracking where all frames have one, and replace it
// only where they were measured from outside.
std::string PosesThatFit(const dataset::Capture& capture) {
  if (!capture.has_poses) return "";
  if (!capture.poses_fault.empty())
    return "; use --poses track: those that came with it are misread";
  const std::vector<dataset::StoredFrame>& frames = capture.stored->frames();
  const auto num_posed = std::ranges::count_if(frames, [](const dataset::StoredFrame& frame) {
    return frame.world_from_colour.has_value();
  });
  return fmt::format(
      "; {} of {} frames have poses that fit the depth: --poses prior starts tracking from them, "
      "--poses capture takes them as they are (true ones alone)",
      num_posed,
      frames.size());
}

Finding CheckCapture(const std::string& folder) {
  const Result<dataset::Capture> capture = layouts::OpenCapture(folder);
  if (!capture.ok()) return {"capture", false, capture.error().message};
  const int frames = capture->frames->num_frames();
  const PinholeCamera& camera = capture->frames->camera();
  std::string detail = fmt::format(
      "layout {}; {} frames of {} x {}{}{}; a run takes about {:.0f} s on two cores and writes "
      "about {:.0f} MB",
      capture->format,
      frames,
      camera.width,
      camera.height,
      Registration(*capture),
      capture->has_poses ? ", with poses" : "",
      kBaseSeconds + kSecondsPerFrame * frames,
      static_cast<double>(batch::DiskNeedOf(static_cast<std::uintmax_t>(frames)).whole) / 1e6);
  detail += PosesThatFit(*capture);
  for (const std::string& warning : capture->warnings) detail += "; " + warning;
  return {"capture", true, detail};
}

// Of a capture that is read as it is there is nothing to write.
Finding WriteSettings(const std::string& folder) {
  const std::string what = "capture.yaml";
  const Result<dataset::Capture> capture = layouts::OpenCapture(folder);
  if (capture.ok())
    return {what, true, "not needed: " + folder + " is read as layout " + capture->format};
  const Result<dataset::CaptureSettings> settings = layouts::SuggestSettings(folder);
  if (!settings.ok()) return {what, false, settings.error().message};
  const Status written = layouts::WriteSuggestedSettings(folder, *settings);
  if (!written.ok()) return {what, false, written.error().message};
  return {what,
          true,
          fmt::format("written to {}; assumed: {}; correct what is assumed, and take it out of "
                      "'assumed'",
                      (fs::path(folder) / what).string(),
                      fmt::join(settings->assumed, ", "))};
}

struct DoctorArguments {
  std::string capture;
  std::string data;
  bool write_capture_yaml = false;
  ConfigSources sources;
};

int Doctor(const DoctorArguments& arguments) {
  const auto& [capture, data, write_capture_yaml, sources] = arguments;
  if (write_capture_yaml && capture.empty())
    return ReportError(InvalidInput("--write-capture-yaml: name the CAPTURE to write it for"));
  const Result<stages::Config> config = ReadConfig(sources);
  if (!config.ok()) return ReportError(config.error());
  const fs::path data_folder = stages::FindDataFolder(data);
  std::vector<Finding> findings = {
      {"deepslam", true, std::string(stages::kToolVersion)},
      {"processor",
       true,
       fmt::format("{} threads,{}", std::thread::hardware_concurrency(), CpuFeatures())},
      CheckMemory(),
      CheckDisk(),
      {"data folder", true, data_folder.string()},
      CheckWeights(data_folder, *config),
      CheckLibrary(data_folder, *config)};
  const Result<ClassTable> classes = stages::LoadClasses(*config);
  findings.push_back(
      classes.ok() ? Finding{"classes", true, fmt::format("{} classes", classes->classes.size())}
                   : Finding{"classes", false, classes.error().message});
  if (classes.ok()) findings.push_back(CheckNetworks(data_folder, *config, *classes));
  if (write_capture_yaml) findings.push_back(WriteSettings(capture));
  if (!capture.empty()) findings.push_back(CheckCapture(capture));

  JsonArray rows;
  bool all_ok = true;
  for (const Finding& finding : findings) {
    fmt::print(
        stderr, "{:<7} {:<18} {}\n", finding.ok ? "ok" : "MISSING", finding.what, finding.detail);
    all_ok = all_ok && finding.ok;
    JsonObject row;
    row.emplace("what", finding.what);
    row.emplace("ok", finding.ok);
    row.emplace("detail", finding.detail);
    rows.emplace_back(std::move(row));
  }
  if (::isatty(STDOUT_FILENO) == 0) {
    JsonObject document = artifact::NewDocument("deepslam/doctor", 1);
    document.emplace("findings", std::move(rows));
    const Result<std::string> text = DumpJson(std::move(document), "doctor");
    if (Status status = text.ok() ? WriteResult("", *text) : Status(text.error()); !status.ok()) {
      return ReportError(status.error());
    }
  }
  return all_ok ? kExitOk : kExitInput;
}

}  // namespace

void AddDoctor(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<DoctorArguments>();
  CLI::App* doctor = app.add_subcommand(
      "doctor", "What is installed, what is missing and how to get it; what a run would take");
  doctor->add_option("CAPTURE", arguments->capture, "Also look at this capture");
  doctor->add_option("--data", arguments->data, "Folder of weights and furniture library");
  doctor->add_flag("--write-capture-yaml",
                   arguments->write_capture_yaml,
                   "Write CAPTURE/capture.yaml as far as the images tell, with what is assumed");
  AddConfigOptions(*doctor, arguments->sources);
  doctor->callback([&chosen, arguments] { chosen = [arguments] { return Doctor(*arguments); }; });
}

}  // namespace deepslam::tools
