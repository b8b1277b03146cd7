#include <chrono>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "catalogues.h"
#include "commands.h"
#include "console.h"
#include "synth_capture.h"

namespace deepslam::tools {
namespace {

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

int Synthesise(const SynthRequest& request) {
  CatchStopSignals();
  ConsoleListener listener(ParseProgressStyle("auto"), false);
  listener.StageStarts("synth", {});
  const auto start = std::chrono::steady_clock::now();
  const Result<SynthSummary> summary = SynthesiseCapture(request, listener);
  if (!summary.ok()) return ReportError(summary.error());
  for (const std::string& warning : summary->warnings) LogWarning(warning);
  listener.StageDone("synth",
                     fmt::format("{} frames in {}", summary->num_frames, request.out.string()),
                     {SecondsSince(start), 0, 0});
  return kExitOk;
}

}  // namespace

void AddSynth(CLI::App& app, Command& chosen) {
  auto request = std::make_shared<SynthRequest>();
  request->catalogues = kCatalogueFolder;
  CLI::App* synth = app.add_subcommand("synth", "Render a capture with truth from a scene file");
  CLI::Option* scene =
      synth->add_option("SCENE", request->scene_file, "Scene file (YAML), see configs/scenes");
  CLI::Option* home =
      synth->add_option("--home",
                        request->home,
                        "Instead: a home of several furnished rooms, made up by this "
                        "seed, and a walk through it");
  scene->excludes(home);
  synth->add_option("-o,--output", request->out, "Capture folder to make")->required();
  synth->add_option("--rung", request->rung, "Variant of the scene, one of its `rungs`");
  synth->add_option("--frames-per-s",
                    request->frames_per_s,
                    "Films the same way at this rate in place of the scene's (homes: 10)");
  synth
      ->add_option("--field",
                   request->settings,
                   "NAME=VALUE of how it is filmed, as camera.preset=d435 or faults.noise_scale=2; "
                   "may be given again")
      ->allow_extra_args(false);
  synth->add_option("--catalogues", request->catalogues, "Folder with *.sh3f furniture catalogues")
      ->capture_default_str();
  synth
      ->add_option("--furniture",
                   request->furniture,
                   "Folder with furniture of yours (OBJ, glTF, GLB; y up, z front, metres), which "
                   "scenes name by path; may be given again")
      ->allow_extra_args(false);
  synth->callback([&chosen, request, scene, home] {
    if (scene->empty() && home->empty()) throw CLI::RequiredError("SCENE or --home");
    chosen = [request] { return Synthesise(*request); };
  });
}

}  // namespace deepslam::tools
