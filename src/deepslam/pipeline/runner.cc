#include "deepslam/pipeline/runner.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <future>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/core/freed_memory.h"
#include "deepslam/pipeline/decide.h"
#include "deepslam/pipeline/drop.h"
#include "deepslam/pipeline/workspace.h"
#include "deepslam/storage/store.h"

namespace deepslam::pipeline {
namespace {

namespace fs = std::filesystem;
using StringMap = std::map<std::string, std::string>;

double CpuSeconds() {
  struct rusage usage {};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

// The kernel's high-water mark of the process can be set back, so that each stage gets its own
// (proc(5)).
void ResetPeakMemory() { std::ofstream("/proc/self/clear_refs") << "5"; }

double PeakMemoryMib() {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word) {
    double kib = 0;
    if (word == "VmHWM:" && status >> kib) return kib / 1024;
  }
  return 0;
}

Status CannotRename(const fs::path& target, const std::error_code& error) {
  return Failed(fmt::format("{}: cannot rename into place: {}", target.string(), error.message()));
}

// Puts the finished folder in place of an old one at once where the file system can swap, else in
// two renames: a run killed between them finds the stage missing and makes it again.
Status PutInPlaceOf(const fs::path& partial, const fs::path& target) {
  const fs::path old = fmt::format("{}.old-{}", target.string(), ::getpid());
  std::error_code error;
  if (::renameat2(AT_FDCWD, partial.c_str(), AT_FDCWD, target.c_str(), RENAME_EXCHANGE) == 0) {
    fs::rename(partial, old, error);
  } else {
    fs::rename(target, old, error);
    if (!error) fs::rename(partial, target, error);
  }
  if (error) return CannotRename(target, error);
  if (Status status = storage::SyncFolder(target.parent_path()); !status.ok()) return status;
  fs::remove_all(old, error);
  return Ok();
}

// These files of the folder, and itself, are on the disk.
Status SyncStage(const fs::path& folder, const std::vector<std::string>& files) {
  std::vector<fs::path> paths;
  for (const std::string& file : files) paths.push_back(folder / file);
  if (Status status = storage::SyncFiles(paths); !status.ok()) return status;
  return storage::SyncFolder(folder);
}

// A stage in its place whose files are on their way to the disk.
class Syncing {
 public:
  Syncing(fs::path folder, std::vector<std::string> files)
      : folder_(std::move(folder)), done_(std::async(std::launch::async, [this, files] {
          if (Status status = SyncStage(folder_, files); !status.ok()) return status;
          return storage::SyncFolder(folder_.parent_path());
        })) {}

  // To be asked once. What may not be on the disk is taken away.
  Status Wait() {
    Status status = done_.get();
    std::error_code ignored;
    if (!status.ok()) fs::remove_all(folder_, ignored);
    return status;
  }

 private:
  fs::path folder_;
  std::future<Status> done_;
};

class Run {
 public:
  Run(std::span<const Stage> stages, const RunRequest& request, RunListener& listener)
      : stages_(stages), request_(request), listener_(listener) {}

  Status CheckRequest() const {
    std::string known;
    for (const Stage& stage : stages_) known += (known.empty() ? "" : ", ") + stage.name;
    const auto exists = [&](const std::string& name) {
      return std::any_of(
          stages_.begin(), stages_.end(), [&](const Stage& stage) { return stage.name == name; });
    };
    if (!request_.until.empty() && !exists(request_.until)) {
      return InvalidConfig(
          fmt::format("--until {}: no such stage; stages are {}", request_.until, known));
    }
    for (const std::string& name : request_.force) {
      if (!exists(name))
        return InvalidConfig(fmt::format("--force {}: no such stage; stages are {}", name, known));
    }
    return Ok();
  }

  Result<RunReport> Execute() {
    const std::span<const Stage> wanted = WantedStages();
    std::vector<StringMap> external_inputs;
    for (const Stage& stage : wanted) {
      Result<StringMap> inputs =
          stage.external_inputs ? stage.external_inputs() : Result<StringMap>(StringMap());
      if (!inputs.ok())
        return Error{inputs.error().code,
                     fmt::format("{}: {}", stage.name, inputs.error().message)};
      external_inputs.push_back(std::move(inputs).value());
    }
    needed_again_ = DroppedAndNeeded(wanted, external_inputs);
    const Status updated = UpdateAll(wanted, external_inputs);
    const Status synced = AwaitSync();
    if (!updated.ok()) return updated.error();
    if (!synced.ok()) return synced.error();
    if (Status status = DropOthers(wanted); !status.ok()) return status.error();
    return report_;
  }

 private:
  std::span<const Stage> WantedStages() const {
    for (std::size_t i = 0; i < stages_.size(); ++i) {
      if (stages_[i].name == request_.until) return stages_.first(i + 1);
    }
    return stages_;
  }

  // Stages whose dropped files are read by a stage that runs, or may run: whether one whose inputs
  // are made anew runs is known only then.
  std::set<std::string> DroppedAndNeeded(std::span<const Stage> wanted,
                                         std::span<const StringMap> external_inputs) const {
    const auto dropped = [&](const std::string& stage) {
      return IsDropped(request_.workspace, stage);
    };
    std::set<std::string> needed;
    if (std::none_of(
            wanted.begin(), wanted.end(), [&](const Stage& s) { return dropped(s.name); })) {
      return needed;
    }
    StringMap hashes;  // of the stages that certainly stand
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const Stage& stage = wanted[i];
      StringMap inputs;
      for (const std::string& input : stage.inputs) {
        if (const auto it = hashes.find(input); it != hashes.end()) inputs.insert(*it);
      }
      if (inputs.size() < stage.inputs.size() || request_.force.contains(stage.name)) continue;
      const Decision decision =
          Decide(request_.workspace, Expected(stage, std::move(inputs), external_inputs[i]));
      if (decision.reasons.empty()) hashes[stage.name] = ContentHash(decision.manifest->outputs);
    }
    for (auto stage = wanted.rbegin(); stage != wanted.rend(); ++stage) {
      if (hashes.contains(stage->name) && !needed.contains(stage->name)) continue;
      std::copy_if(
          stage->inputs.begin(), stage->inputs.end(), std::inserter(needed, needed.end()), dropped);
    }
    return needed;
  }

  Status DropOthers(std::span<const Stage> wanted) const {
    if (request_.keep.empty()) return Ok();
    for (const Stage& stage : wanted) {
      if (request_.keep.contains(stage.name)) continue;
      if (Status status = DropOutputs(request_.workspace, stage.name); !status.ok()) return status;
    }
    return Ok();
  }

  Status UpdateAll(std::span<const Stage> wanted, std::span<const StringMap> external_inputs) {
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      if (listener_.StopRequested()) return Interrupted();
      if (Status status = Update(wanted[i], external_inputs[i]); !status.ok()) return status;
    }
    return Ok();
  }

  // The stage made before this one is on the disk.
  Status AwaitSync() {
    if (!syncing_) return Ok();
    const std::unique_ptr<Syncing> last = std::move(syncing_);
    return last->Wait();
  }

  Status Update(const Stage& stage, const StringMap& external_inputs) {
    StringMap inputs;
    for (const std::string& input : stage.inputs) {
      const auto it = content_hashes_.find(input);
      DEEPSLAM_CHECK(it != content_hashes_.end(),
                     "stage " + input + " must stand before " + stage.name);
      inputs.emplace(input, it->second);
    }
    Manifest manifest = Expected(stage, std::move(inputs), external_inputs);
    Decision decision = Decide(request_.workspace, manifest);
    if (decision.reasons.empty() && request_.force.contains(stage.name))
      decision.reasons.emplace_back("forced");
    if (decision.reasons.empty() && decision.dropped && needed_again_.contains(stage.name))
      decision.reasons.emplace_back("its files were dropped and are needed again");
    if (decision.reasons.empty()) {
      content_hashes_[stage.name] = ContentHash(decision.manifest->outputs);
      report_.skipped.push_back(stage.name);
      listener_.StageSkipped(stage.name, decision.manifest->summary.line);
      return Ok();
    }
    listener_.StageStarts(stage.name, decision.reasons);
    const Result<Timing> timing = Make(stage, manifest);
    if (!timing.ok()) {
      if (timing.error().code == ErrorCode::kInterrupted) return timing.error();
      return Error{timing.error().code, fmt::format("{}: {}", stage.name, timing.error().message)};
    }
    content_hashes_[stage.name] = ContentHash(manifest.outputs);
    report_.ran.push_back(stage.name);
    listener_.StageDone(stage.name, manifest.summary.line, *timing);
    return Ok();
  }

  // Runs the stage into a folder aside and puts it in place; fills outputs and summary of the
  // manifest.
  Result<Timing> Make(const Stage& stage, Manifest& manifest) {
    const fs::path partial =
        request_.workspace / fmt::format("{}.partial-{}", stage.name, ::getpid());
    if (Status status = storage::MakeFolders(partial); !status.ok()) return status.error();
    Result<Timing> timing = MakeIn(partial, stage, manifest);
    std::error_code ignored;
    fs::remove_all(partial, ignored);  // what an error left; nothing after a success
    return timing;
  }

  Result<Timing> MakeIn(const fs::path& partial, const Stage& stage, Manifest& manifest) {
    const auto start = std::chrono::steady_clock::now();
    const double start_cpu_s = CpuSeconds();
    ResetPeakMemory();
    StageContext context(request_.workspace, partial, stage.inputs, listener_);
    Result<StageSummary> summary = stage.run(context);
    ReturnFreedMemory(kMostHeldBytes);
    if (!summary.ok()) return summary.error();
    if (const std::optional<Error> fault = context.scratch_fault()) return *fault;
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
    const Timing timing{wall.count(), CpuSeconds() - start_cpu_s, PeakMemoryMib()};
    manifest.outputs = context.outputs();
    manifest.summary = std::move(summary).value();
    const Result<std::string> timing_text = EncodeTiming(timing, kTimingFile);
    const Result<std::string> manifest_text = EncodeManifest(manifest, kManifestFile);
    if (!timing_text.ok()) return timing_text.error();
    if (!manifest_text.ok()) return manifest_text.error();
    for (const auto& [file, text] :
         {std::pair(kTimingFile, &*timing_text), std::pair(kManifestFile, &*manifest_text)}) {
      if (Status status = storage::WriteFileUnsynced(partial / file, *text); !status.ok())
        return status.error();
    }
    if (Status status = Place(partial, stage, manifest); !status.ok()) return status.error();
    return timing;
  }

  // Only behind what was made before. An older result is replaced by one that is on the disk; where
  // there is none, the next stage need not wait for that.
  Status Place(const fs::path& partial, const Stage& stage, const Manifest& manifest) {
    std::vector<std::string> files = {std::string(kTimingFile), std::string(kManifestFile)};
    for (const auto& [file, output] : manifest.outputs) files.push_back(file);
    const fs::path target = request_.workspace / stage.name;
    if (Status status = AwaitSync(); !status.ok()) return status;
    std::error_code error;
    if (fs::exists(target, error)) {
      if (Status status = SyncStage(partial, files); !status.ok()) return status;
      return PutInPlaceOf(partial, target);
    }
    fs::rename(partial, target, error);
    if (error) return CannotRename(target, error);
    syncing_ = std::make_unique<Syncing>(target, std::move(files));
    return Ok();
  }

  std::span<const Stage> stages_;
  const RunRequest& request_;
  RunListener& listener_;
  StringMap content_hashes_;
  std::set<std::string> needed_again_;
  RunReport report_;
  std::unique_ptr<Syncing> syncing_;
};

std::vector<std::string> Names(std::span<const Stage> stages) {
  std::vector<std::string> names;
  for (const Stage& stage : stages) names.push_back(stage.name);
  return names;
}

std::optional<Timing> ReadTiming(const fs::path& folder) {
  const Result<std::string> text = storage::ReadFile(folder / kTimingFile);
  if (!text.ok()) return std::nullopt;
  const Result<Timing> found = DecodeTiming(*text, kTimingFile);
  return found.ok() ? std::optional(*found) : std::nullopt;
}

}  // namespace

Result<RunReport> RunStages(std::span<const Stage> stages,
                            const RunRequest& request,
                            RunListener& listener) {
  Run run(stages, request, listener);
  if (Status status = run.CheckRequest(); !status.ok()) return status.error();
  const std::vector<std::string> names = Names(stages);
  const Result<Workspace> workspace =
      Workspace::Open(request.workspace, names, request.lock_patience_s);
  if (!workspace.ok()) return workspace.error();
  for (const auto& [file, bytes] : request.notes) {
    if (Status status = storage::WriteFileAtomically(request.workspace / file, bytes);
        !status.ok()) {
      return status.error();
    }
  }
  return run.Execute();
}

std::vector<StageTiming> ReadTimings(std::span<const Stage> stages, const fs::path& workspace) {
  std::vector<StageTiming> timings;
  for (const Stage& stage : stages) {
    if (const std::optional<Timing> timing = ReadTiming(workspace / stage.name)) {
      timings.push_back({stage.name, *timing});
    }
  }
  return timings;
}

namespace {

// What can be looked at counts as it is now.
void TakeCurrent(const Stage& stage,
                 std::span<const std::string_view> looked_at,
                 StringMap& external_inputs) {
  if (!stage.external_inputs) return;
  const Result<StringMap> current = stage.external_inputs();
  if (!current.ok()) return;
  for (const std::string_view name : looked_at) {
    const std::string key(name);
    external_inputs.erase(key);
    if (const auto found = current->find(key); found != current->end())
      external_inputs.insert(*found);
  }
}

}  // namespace

Result<std::vector<StageReport>> InspectWorkspace(std::span<const Stage> stages,
                                                  const fs::path& workspace,
                                                  std::span<const std::string_view> looked_at) {
  if (Status status = CheckWorkspace(workspace, false); !status.ok()) return status.error();
  std::vector<StageReport> reports;
  StringMap content_hashes;
  for (const Stage& stage : stages) {
    StringMap inputs;
    std::vector<std::string> waiting;
    for (const std::string& input : stage.inputs) {
      const auto it = content_hashes.find(input);
      if (it == content_hashes.end()) {
        waiting.push_back(fmt::format("input {} is to be made first", input));
      } else {
        inputs.emplace(input, it->second);
      }
    }
    // What the last run recorded stands for what cannot be looked at here.
    StringMap external_inputs;
    const Decision recorded = Decide(workspace, Expected(stage, inputs, {}));
    if (recorded.manifest) external_inputs = recorded.manifest->external_inputs;
    if (!looked_at.empty()) TakeCurrent(stage, looked_at, external_inputs);
    Decision decision =
        Decide(workspace, Expected(stage, std::move(inputs), std::move(external_inputs)));
    if (!waiting.empty() && !decision.missing) decision.reasons = waiting;
    StageReport report{stage.name, StageState::kMissing, decision.reasons, {}, 0, {}};
    if (decision.manifest) {
      report.state = decision.reasons.empty() ? StageState::kDone : StageState::kStale;
      report.summary = decision.manifest->summary.line;
      if (decision.dropped && decision.reasons.empty()) {
        report.state = StageState::kDropped;
      } else {
        for (const auto& [file, output] : decision.manifest->outputs)
          report.num_bytes += output.num_bytes;
      }
      report.timing = ReadTiming(workspace / stage.name).value_or(Timing());
      if (decision.reasons.empty())
        content_hashes[stage.name] = ContentHash(decision.manifest->outputs);
    } else if (!decision.missing) {
      report.state = StageState::kStale;
    }
    reports.push_back(std::move(report));
  }
  return reports;
}

}  // namespace deepslam::pipeline
