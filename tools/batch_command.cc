// `deepslam batch`: many captures, one workspace each.
#include <fcntl.h>
#include <sys/file.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <numeric>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "batch_capture.h"
#include "batch_display.h"
#include "batch_local.h"
#include "batch_slurm.h"
#include "batch_summary.h"
#include "commands.h"
#include "console.h"
#include "deepslam/artifact/json_reader.h"
#include "deepslam/batch/capture_list.h"
#include "deepslam/batch/forecast.h"
#include "deepslam/batch/progress_table.h"
#include "deepslam/stages/data_folder.h"
#include "deepslam/stages/plan.h"
#include "deepslam/storage/store.h"
#include "run_capture.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;
using batch::BatchFolder;
using batch::BatchPlan;
using batch::BatchState;
using batch::CaptureRecord;
using batch::CaptureState;

constexpr int kThreadsPerJob = 2;  // captures side by side use cores better than threads of one
constexpr double kMemoryMibPerJob = 800;  // a room of 500 frames of 640 x 480, with networks

struct BatchArguments {
  std::vector<std::string> captures;
  std::string root;
  ConfigSources config;
  std::string poses;
  std::string until;
  std::string keep = "all";
  std::string engine = "local";
  std::string data;
  std::string progress = "auto";
  int jobs = 0;
  int threads = 0;
  bool ignore_disk = false;
  SlurmArguments slurm;
};

// One batch at a time in a folder, while the object lives.
class RootLock {
 public:
  static Result<RootLock> Take(const BatchFolder& folder) {
    const int fd = ::open(folder.lock().c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (fd < 0) {
      return Failed(fmt::format("{}: cannot write: {}; choose a folder you may write to",
                                folder.lock().string(),
                                std::strerror(errno)));
    }
    if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
      ::close(fd);
      return Failed(
          fmt::format("{}: another batch works in this folder; wait for it, or choose "
                      "another one",
                      folder.root.string()));
    }
    RootLock lock(fd);
    for (const fs::path& written : {folder.root, folder.internals()}) {
      if (Status status = storage::RemoveAsideFiles(written); !status.ok()) return status.error();
    }
    return lock;
  }
  ~RootLock() {
    if (fd_ >= 0) ::close(fd_);
  }
  RootLock(RootLock&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  RootLock& operator=(RootLock&&) = delete;

 private:
  explicit RootLock(int fd) : fd_(fd) {}
  int fd_;
};

std::vector<std::string> StageNames() {
  const auto inputs =
      std::make_shared<const stages::RunInputs>(stages::RunInputs{{}, {}, nullptr, {}});
  std::vector<std::string> names;
  for (const pipeline::Stage& stage : stages::MakePlan(inputs)) names.push_back(stage.name);
  return names;
}

Status CheckUntil(const std::string& until, const std::vector<std::string>& stage_names) {
  if (until.empty() ||
      std::find(stage_names.begin(), stage_names.end(), until) != stage_names.end()) {
    return Ok();
  }
  std::string known;
  for (const std::string& name : stage_names) known += (known.empty() ? "" : ", ") + name;
  return InvalidConfig(fmt::format("--until {}: no such stage; stages are {}", until, known));
}

// A file or another program's folder is no place for a batch.
Status CheckRoot(const fs::path& root) {
  std::error_code error;
  if (!fs::exists(root, error)) return Ok();
  if (!fs::is_directory(root, error)) {
    return InvalidConfig(
        fmt::format("--output {}: is a file; name a folder for the batch", root.string()));
  }
  if (fs::exists(root / "workspace.json", error)) {
    return InvalidConfig(fmt::format(
        "--output {}: is the workspace of a single run; name another folder for the batch",
        root.string()));
  }
  return Ok();
}

std::uintmax_t BytesThere(const fs::path& folder) {
  std::uintmax_t sum = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    std::error_code ignored;
    const std::uintmax_t size = it->is_regular_file(ignored) ? it->file_size(ignored) : 0;
    if (!ignored) sum += size;
  }
  return sum;
}

// What the batch will write beyond what lies there, and whether there is room for it.
Status CheckDisk(const BatchFolder& folder, const BatchPlan& plan, int jobs, bool ignore) {
  std::uintmax_t needed = 0;
  std::vector<std::uintmax_t> at_work;  // what an unfinished capture takes beyond what is kept
  for (const batch::PlannedCapture& capture : plan.captures) {
    const batch::DiskNeed need = batch::EstimateDiskNeed(capture.path);
    const std::uintmax_t there = BytesThere(folder.root / capture.name);
    const std::uintmax_t final_bytes = plan.keep_final ? need.kept : need.whole;
    // What was finished before needs nothing more.
    if (ReadRecordOf(folder, capture).state == CaptureState::kDone) continue;
    needed += final_bytes > there ? final_bytes - there : 0;
    at_work.push_back(need.whole - final_bytes);
  }
  std::sort(at_work.rbegin(), at_work.rend());
  const std::size_t at_a_time =
      std::min(at_work.size(), jobs > 0 ? static_cast<std::size_t>(jobs) : at_work.size());
  for (std::size_t i = 0; i < at_a_time; ++i) needed += at_work[i];

  struct statvfs status {};
  if (::statvfs(folder.root.c_str(), &status) != 0) return Ok();
  const double free_bytes =
      static_cast<double>(status.f_bavail) * static_cast<double>(status.f_frsize);
  const double needed_bytes = static_cast<double>(needed);
  LogInfo(fmt::format("disk: about {:.2f} GB will be written, {:.1f} GB are free",
                      needed_bytes / 1e9,
                      free_bytes / 1e9));
  if (needed_bytes <= free_bytes) return Ok();
  const std::string message = fmt::format(
      "{}: the batch will write about {:.2f} GB, but {:.2f} GB are free; free some space{}",
      folder.root.string(),
      needed_bytes / 1e9,
      free_bytes / 1e9,
      plan.keep_final ? "" : ", or let --keep final drop what is not needed in the end");
  if (!ignore) return Failed(message + "; --ignore-disk starts nevertheless");
  LogWarning(message);
  return Ok();
}

void WarnAboutMemory(int jobs) {
  std::ifstream file("/proc/meminfo");
  std::string word;
  while (file >> word) {
    double kib = 0;
    if (word != "MemAvailable:" || !(file >> kib)) continue;
    if (jobs * kMemoryMibPerJob > kib / 1024) {
      LogWarning(
          fmt::format("{} captures at a time take about {:.0f} MiB of memory, but {:.0f} MiB "
                      "are free; captures may be killed: give fewer --jobs",
                      jobs,
                      jobs * kMemoryMibPerJob,
                      kib / 1024));
    }
    return;
  }
}

int Cores() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

// What is known of captures from an earlier call stays known until they are looked at again.
BatchState FirstState(const BatchFolder& folder, const BatchPlan& plan) {
  BatchState state;
  state.tool_version = stages::kToolVersion;
  state.state = "running";
  state.started_s = static_cast<std::int64_t>(NowSeconds());
  for (const batch::PlannedCapture& capture : plan.captures) {
    CaptureRecord record = ReadRecordOf(folder, capture);
    record.capture = capture.path.string();
    record.state = CaptureState::kWaiting;
    record.reason.clear();
    record.exit_code = 0;
    record.process = 0;
    record.stage.clear();
    record.done = record.total = 0;
    state.captures.push_back(std::move(record));
  }
  return state;
}

std::vector<std::size_t> AllOf(const BatchPlan& plan) {
  std::vector<std::size_t> indices(plan.captures.size());
  std::iota(indices.begin(), indices.end(), std::size_t{0});
  return indices;
}

bool IsSameFolder(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code error;
  return std::filesystem::equivalent(a, b, error) && !error;
}

Result<BatchPlan> MakeBatchPlan(const BatchArguments& arguments) {
  ConfigSources sources = arguments.config;
  if (!arguments.poses.empty()) sources.settings.push_back("track.poses=" + arguments.poses);
  const Result<stages::Config> config = ReadConfig(sources);
  if (!config.ok()) return config.error();
  if (const Result<ClassTable> classes = stages::LoadClasses(*config); !classes.ok())
    return classes.error();
  const Result<std::string> options = EncodeRun(*config);
  if (!options.ok()) return options.error();
  Result<std::vector<batch::ListedCapture>> captures = batch::FindCaptures(arguments.captures);
  if (!captures.ok()) return captures.error();
  // A pattern beside which the results lie matches them the next time.
  std::erase_if(*captures, [&](const batch::ListedCapture& capture) {
    return capture.by_pattern && IsSameFolder(capture.path, arguments.root);
  });
  if (captures->empty())
    return InvalidInput("the patterns match nothing but the batch's own folder");
  BatchPlan plan;
  for (const batch::ListedCapture& capture : *captures)
    plan.captures.push_back({capture.path, capture.name});
  plan.run_options = *options;
  plan.until = arguments.until;
  plan.keep_final = arguments.keep == "final";
  std::error_code error;
  plan.data_folder = fs::absolute(stages::FindDataFolder(arguments.data), error);
  return plan;
}

// What a batch that came to its end says to people.
void TellResult(const BatchFolder& folder, const BatchState& state) {
  const batch::StateCounts counts = Count(state);
  LogInfo(fmt::format("{} of {} done{}, {}",
                      counts.done,
                      state.captures.size(),
                      counts.failed > 0 ? fmt::format(", {} failed", counts.failed) : "",
                      batch::DurationText(static_cast<double>(state.ended_s - state.started_s))));
  if (counts.failed > 0) {
    std::string names;
    for (const CaptureRecord& record : state.captures) {
      if (record.state == CaptureState::kFailed) names += " " + record.name;
    }
    LogError("failed:" + names);
  }
  LogInfo(fmt::format("page      {}", folder.page().string()));
  LogInfo(fmt::format("table     {}", folder.batch_json().string()));
}

// The same for programs.
Status TellDocument(const BatchFolder& folder) {
  if (::isatty(STDOUT_FILENO) != 0) return Ok();
  const Result<std::string> text = storage::ReadFile(folder.batch_json());
  return text.ok() ? WriteResult("", *text) : Status(text.error());
}

int Finish(const BatchFolder& folder,
           const BatchPlan& plan,
           const Status& outcome,
           BatchState& state) {
  state.ended_s = static_cast<std::int64_t>(NowSeconds());
  state.state = outcome.ok() ? "done" : "interrupted";
  for (std::size_t i = 0; i < state.captures.size(); ++i) {
    CaptureRecord& record = state.captures[i];
    if (record.state == CaptureState::kRunning) record.state = CaptureState::kInterrupted;
    // Not reached this time: what is known from before still holds.
    if (record.state == CaptureState::kWaiting) record = ReadRecordOf(folder, plan.captures[i]);
  }
  if (Status status = WriteBatchFile(folder, state); !status.ok())
    return ReportError(status.error());
  if (Status status = WriteBatchPage(folder, state); !status.ok())
    return ReportError(status.error());
  if (!outcome.ok()) return ReportError(outcome.error());
  TellResult(folder, state);
  return ExitCode(state);
}

int Batch(const BatchArguments& arguments) {
  if (arguments.root.empty())
    return ReportError(InvalidConfig("--output: names no folder; give the batch's"));
  std::vector<std::string> stage_names = StageNames();
  if (Status status = CheckUntil(arguments.until, stage_names); !status.ok())
    return ReportError(status.error());
  std::error_code error;
  fs::path root = fs::absolute(arguments.root, error).lexically_normal();
  if (!root.has_filename()) root = root.parent_path();
  const BatchFolder folder{root};
  if (Status status = CheckRoot(root); !status.ok()) return ReportError(status.error());
  Result<BatchPlan> plan = MakeBatchPlan(arguments);
  if (!plan.ok()) return ReportError(plan.error());

  const bool local = arguments.engine == "local";
  const int num_captures = static_cast<int>(plan->captures.size());
  int jobs = arguments.jobs;
  if (local) {
    const int threads = arguments.threads > 0 ? arguments.threads : Cores();
    if (jobs == 0) jobs = std::max(1, threads / kThreadsPerJob);
    jobs = std::min(jobs, num_captures);
    plan->num_threads = std::max(1, threads / jobs);
  } else {
    plan->num_threads = arguments.threads > 0 ? arguments.threads : kThreadsPerJob;
    if (Status status = CheckSlurm(); !status.ok()) return ReportError(status.error());
  }
  if (Status status = storage::MakeFolders(folder.internals()); !status.ok())
    return ReportError(status.error());
  const Result<RootLock> lock = RootLock::Take(folder);
  if (!lock.ok()) return ReportError(lock.error());
  if (Status status = CheckDisk(folder, *plan, jobs, arguments.ignore_disk); !status.ok())
    return ReportError(status.error());
  if (local) WarnAboutMemory(jobs);

  BatchState state = FirstState(folder, *plan);
  state.engine = arguments.engine;
  state.jobs = jobs;
  CatchStopSignals();
  if (const auto last = std::find(stage_names.begin(), stage_names.end(), arguments.until);
      last != stage_names.end()) {
    stage_names.erase(last + 1, stage_names.end());
  }
  BatchDisplay display(ParseBatchStyle(arguments.progress), stage_names);
  Status outcome = Ok();
  if (local) {
    outcome = WritePlan(folder, *plan);
    const auto save = [&] { return WriteBatchFile(folder, state); };
    if (outcome.ok()) outcome = save();
    if (outcome.ok()) outcome = RunLocally(folder, AllOf(*plan), save, display, state);
  } else {
    const Result<bool> ended = RunOnSlurm(folder, *plan, arguments.slurm, display, state);
    if (ended.ok() && !*ended) return kExitOk;
    if (!ended.ok()) outcome = ended.error();
  }
  display.Finish();
  const int code = Finish(folder, *plan, outcome, state);
  if (Status status = TellDocument(folder); !status.ok()) return ReportError(status.error());
  return code;
}

// What the summary job of a cluster does.
int Summarise(const std::string& root) {
  const Result<BatchWork> work = ReadWork(root);
  if (!work.ok()) return ReportError(work.error());
  BatchState state = FirstState(work->folder, work->plan);
  if (const Result<std::string> text = storage::ReadFile(work->folder.batch_json()); text.ok()) {
    const Result<BatchState> known = batch::DecodeBatch(*text, "batch.json");
    if (known.ok()) state.started_s = known->started_s;
    if (known.ok()) state.jobs = known->jobs;
  }
  state.engine = "slurm";
  GatherRecords(work->folder, work->plan, true, state);
  return Finish(work->folder, work->plan, Ok(), state);
}

}  // namespace

void AddBatch(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<BatchArguments>();
  CLI::App* batch_command = app.add_subcommand(
      "batch", "Many captures, one workspace each; a bad capture never stops the others");
  batch_command
      ->add_option("CAPTURES",
                   arguments->captures,
                   "List files (one capture per line: PATH or PATH NAME), captures, or patterns in "
                   "quotes ('rooms/*')")
      ->required();
  batch_command
      ->add_option("-o,--output",
                   arguments->root,
                   "Folder of the batch: a workspace per capture, batch.json, index.html")
      ->required();
  batch_command
      ->add_option("--jobs",
                   arguments->jobs,
                   "Captures at a time; 0: one per two threads, on a cluster as many as it takes")
      ->check(CLI::Range(0, 10000))
      ->capture_default_str();
  AddConfigOptions(*batch_command, arguments->config);
  batch_command
      ->add_option("--poses",
                   arguments->poses,
                   "track: estimate camera poses; capture: use those of the captures; prior: start "
                   "from them")
      ->check(CLI::IsMember({"track", "capture", "prior"}));
  batch_command->add_option("--until", arguments->until, "Last stage to run");
  batch_command
      ->add_option("--threads",
                   arguments->threads,
                   "Threads of all jobs together, 0 = all cores; on a cluster of each task, 0 = 2")
      ->check(CLI::Range(0, 1024));
  batch_command
      ->add_option(
          "--keep",
          arguments->keep,
          "all, or final: when a capture is done, drop the files that only its stages need")
      ->check(CLI::IsMember({"all", "final"}))
      ->capture_default_str();
  batch_command->add_option("--progress", arguments->progress, "auto, table, lines or none")
      ->check(CLI::IsMember({"auto", "table", "lines", "none"}))
      ->capture_default_str();
  batch_command->add_option("--data",
                            arguments->data,
                            "Folder of weights and furniture library (default: see `deepslam "
                            "doctor`)");
  batch_command->add_flag(
      "--ignore-disk", arguments->ignore_disk, "Start although the disk seems too small");
  batch_command
      ->add_option("--engine",
                   arguments->engine,
                   "local: processes on this machine; slurm: an array of jobs by sbatch")
      ->check(CLI::IsMember({"local", "slurm"}))
      ->capture_default_str();
  SlurmArguments& slurm = arguments->slurm;
  batch_command->add_option("--partition", slurm.options.partition, "Slurm: partition");
  batch_command->add_option("--time", slurm.options.time, "Slurm: time limit of a task");
  batch_command->add_option("--mem", slurm.options.memory, "Slurm: memory of a task");
  batch_command
      ->add_option("--sbatch",
                   slurm.options.more,
                   "Slurm: further option of sbatch (--sbatch=--account=x); may be repeated")
      ->expected(1)
      ->take_all();
  batch_command
      ->add_option("--per-task",
                   slurm.per_task,
                   "Slurm: captures of one task; 0: one, or as many as the array's limit asks for")
      ->check(CLI::Range(0, 1000000));
  batch_command->add_flag_callback(
      "--no-wait",
      [arguments] { arguments->slurm.wait = false; },
      "Slurm: submit and return; the summary is a job as well");
  batch_command->callback(
      [&chosen, arguments] { chosen = [arguments] { return Batch(*arguments); }; });
}

void AddBatchSummary(CLI::App& app, Command& chosen) {
  auto root = std::make_shared<std::string>();
  CLI::App* summary = app.add_subcommand("batch-summary", "batch.json and page of a batch");
  summary->group("");
  summary->add_option("ROOT", *root, "Folder of the batch")->required();
  summary->callback([&chosen, root] { chosen = [root] { return Summarise(*root); }; });
}

}  // namespace deepslam::tools
