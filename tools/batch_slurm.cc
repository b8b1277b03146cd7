#include "batch_slurm.h"

#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "batch_capture.h"
#include "batch_summary.h"
#include "commands.h"
#include "console.h"
#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/json_value.h"
#include "deepslam/batch/run_program.h"
#include "deepslam/storage/store.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;
using batch::CaptureRecord;
using batch::CaptureState;

constexpr std::string_view kJobsFormat = "deepslam/batch_jobs";
constexpr int kJobsVersion = 1;  // rises with every change of the file
constexpr auto kLookInterval = std::chrono::milliseconds(1000);  // at the records
constexpr auto kQueueInterval = std::chrono::seconds(5);         // squeue
constexpr auto kCancelPatience = std::chrono::seconds(60);       // twice Slurm's default KillWait
constexpr int kMaxJobsAsked = 50;  // scontrol, for captures that ended without a word
constexpr int kFewestTasks = 1;    // of an array, whatever MaxArraySize says

constexpr std::string_view kSummaryScript =
    "#!/bin/sh\n"
    "# batch.json and the page: deepslam, folder of the batch.\n"
    "exec \"$1\" batch-summary \"$2\"\n";

struct Jobs {
  std::string array_id;
  std::string summary_id;
  int per_task = 1;
};

Status WriteJobs(const batch::BatchFolder& folder, const Jobs& jobs) {
  artifact::JsonObject document = artifact::NewDocument(kJobsFormat, kJobsVersion);
  document.emplace("array_id", jobs.array_id);
  document.emplace("summary_id", jobs.summary_id);
  document.emplace("per_task", jobs.per_task);
  const Result<std::string> text = DumpJson(std::move(document), "jobs.json");
  if (!text.ok()) return text.error();
  return storage::WriteFileAtomically(folder.jobs(), *text);
}

Result<Jobs> ReadJobs(const batch::BatchFolder& folder) {
  const Result<std::string> text = storage::ReadFile(folder.jobs());
  if (!text.ok()) return text.error();
  artifact::JsonReader reader(*text, folder.jobs().string(), kJobsFormat, kJobsVersion);
  Jobs jobs{reader.root()["array_id"].String(),
            reader.root()["summary_id"].String(),
            reader.root()["per_task"].Int(1, 1'000'000)};
  return reader.Finish(std::move(jobs));
}

std::string Trimmed(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

Result<bool> AskQueue(const Jobs& jobs) {
  const auto queue = batch::RunProgram(
      {"squeue", "--noheader", "--user=" + std::to_string(::getuid()), "--format=%F"});
  if (!queue.ok()) return queue.error();
  if (queue->exit_code != 0)
    return Failed("squeue does not tell what is at work: " + Trimmed(queue->err));
  const std::vector<std::string> ids = {jobs.array_id, jobs.summary_id};
  return batch::AnyInQueue(queue->out, ids);
}

// Also where the queue cannot be asked just now: a controller that restarts answers later.
bool AtWork(const Jobs& jobs) {
  const Result<bool> answer = AskQueue(jobs);
  return !answer.ok() || *answer;
}

Result<std::string> Submit(const std::vector<std::string>& command) {
  const auto output = batch::RunProgram(command);
  if (!output.ok()) return output.error();
  if (output->exit_code != 0) {
    return Failed("sbatch refused the job: " + Trimmed(output->err));
  }
  return batch::ParseJobId(output->out);
}

int MaxTasks() {
  const auto config = batch::RunProgram({"scontrol", "show", "config"});
  return std::max(kFewestTasks,
                  batch::ParseMaxArraySize(config.ok() ? config->out : std::string()) - 1);
}

Result<Jobs> SubmitAll(const batch::BatchFolder& folder,
                       const batch::BatchPlan& plan,
                       const SlurmArguments& arguments,
                       int at_a_time) {
  batch::SlurmBatch batch;
  batch.root = folder.root;
  std::error_code error;
  batch.program = fs::read_symlink("/proc/self/exe", error);
  batch.script = folder.internals() / "task.sh";
  batch.num_captures = static_cast<int>(plan.captures.size());
  batch.per_task = arguments.per_task > 0 ? arguments.per_task
                                          : batch::CapturesPerTask(batch.num_captures, MaxTasks());
  batch.at_a_time = at_a_time;
  batch.num_threads = plan.num_threads;
  batch.options = arguments.options;
  for (const auto& [file, text] : {std::pair(batch.script, batch::SlurmTaskScript()),
                                   std::pair(folder.internals() / "summary.sh", kSummaryScript)}) {
    if (Status status = storage::WriteFileAtomically(file, text); !status.ok())
      return status.error();
  }
  Jobs jobs;
  jobs.per_task = batch.per_task;
  Result<std::string> id = Submit(SubmitArray(batch));
  if (!id.ok()) return id.error();
  jobs.array_id = *id;
  id = Submit(SubmitSummary(batch, jobs.array_id));
  if (!id.ok()) {
    static_cast<void>(batch::RunProgram({"scancel", jobs.array_id}));
    return id.error();
  }
  jobs.summary_id = *id;
  if (Status status = WriteJobs(folder, jobs); !status.ok()) return status.error();
  LogInfo(fmt::format("submitted {} captures as job {} of Slurm, the summary as job {}",
                      batch.num_captures,
                      jobs.array_id,
                      jobs.summary_id));
  return jobs;
}

// Why a capture whose job is over has no result.
std::string WithoutResult(const CaptureRecord& record, const std::string& job_state) {
  std::string text = record.state == CaptureState::kInterrupted
                         ? "was stopped by Slurm before its end"
                         : "its job ended without a result";
  if (!record.stage.empty()) text += " in stage " + record.stage;
  if (!record.host.empty()) text += " on " + record.host;
  if (!job_state.empty()) text += ": " + job_state;
  return text + "; see the logs in .batch/logs, and run the batch again to continue";
}

class Watch {
 public:
  Watch(const batch::BatchFolder& folder,
        const batch::BatchPlan& plan,
        const Jobs& jobs,
        BatchDisplay& display,
        batch::BatchState& state)
      : folder_(folder), plan_(plan), jobs_(jobs), display_(display), state_(state) {}

  Status UntilEnd() {
    auto asked = std::chrono::steady_clock::now();
    while (true) {
      if (Status status = Look(); !status.ok()) return status;
      if (StopSignalled()) return Cancel();
      if (std::chrono::steady_clock::now() - asked >= kQueueInterval) {
        asked = std::chrono::steady_clock::now();
        if (!AtWork(jobs_)) break;
      }
      std::this_thread::sleep_for(kLookInterval);
    }
    if (Status status = Look(); !status.ok()) return status;
    GatherRecords(folder_, plan_, true, state_);
    return Ok();
  }

 private:
  // Reads the records that changed.
  Status Look() {
    bool changed = false;
    for (std::size_t i = 0; i < state_.captures.size(); ++i) {
      struct stat status {};
      if (::stat(folder_.record(plan_.captures[i].name).c_str(), &status) != 0) continue;
      const std::pair<std::int64_t, std::int64_t> time(status.st_mtim.tv_sec,
                                                       status.st_mtim.tv_nsec);
      if (seen_[i] == time) continue;
      seen_[i] = time;
      changed = true;
      CaptureRecord& record = state_.captures[i];
      record = ReadRecordOf(folder_, plan_.captures[i]);
      if (record.state == CaptureState::kDone || record.state == CaptureState::kFailed)
        display_.Ended(record, ++num_ended_, state_.captures.size());
    }
    display_.Update(state_);
    return changed ? WriteBatchFile(folder_, state_) : Ok();
  }

  // Tasks get SIGTERM from Slurm and leave their stages whole or not at all.
  Status Cancel() {
    static_cast<void>(batch::RunProgram({"scancel", jobs_.array_id, jobs_.summary_id}));
    const auto start = std::chrono::steady_clock::now();
    while (AtWork(jobs_) && std::chrono::steady_clock::now() - start < kCancelPatience)
      std::this_thread::sleep_for(kLookInterval);
    GatherRecords(folder_, plan_, false, state_);
    return Interrupted();
  }

  const batch::BatchFolder& folder_;
  const batch::BatchPlan& plan_;
  const Jobs& jobs_;
  BatchDisplay& display_;
  batch::BatchState& state_;
  std::map<std::size_t, std::pair<std::int64_t, std::int64_t>> seen_;
  std::size_t num_ended_ = 0;
};

Status WriteWaitingRecords(const batch::BatchFolder& folder, const batch::BatchState& state) {
  for (const CaptureRecord& record : state.captures) {
    if (Status status = WriteRecord(folder, record); !status.ok()) return status;
  }
  return Ok();
}

bool SamePlan(const batch::BatchFolder& folder, const batch::BatchPlan& plan) {
  const Result<std::string> text = storage::ReadFile(folder.plan());
  const Result<std::string> wanted = batch::EncodePlan(plan, "plan.json");
  return text.ok() && wanted.ok() && *text == *wanted;
}

}  // namespace

Status CheckSlurm() {
  for (const char* program : {"sbatch", "squeue", "scancel", "scontrol"}) {
    if (batch::HasProgram(program)) continue;
    return InvalidConfig(fmt::format(
        "--engine slurm: no program '{}' in PATH; run this where Slurm's client programs are "
        "installed (a login node; Debian package slurm-client), or use --engine local",
        program));
  }
  return Ok();
}

void GatherRecords(const batch::BatchFolder& folder,
                   const batch::BatchPlan& plan,
                   bool jobs_are_over,
                   batch::BatchState& state) {
  const Result<Jobs> jobs = ReadJobs(folder);
  int num_asked = 0;
  for (std::size_t i = 0; i < plan.captures.size(); ++i) {
    CaptureRecord record = ReadRecordOf(folder, plan.captures[i]);
    const bool ended = record.state == CaptureState::kDone || record.state == CaptureState::kFailed;
    if (!ended && jobs_are_over) {
      std::string job_state;
      if (jobs.ok() && ++num_asked <= kMaxJobsAsked) {
        const auto told = batch::RunProgram(
            {"scontrol",
             "show",
             "job",
             "-o",
             fmt::format("{}_{}", jobs->array_id, i / static_cast<std::size_t>(jobs->per_task))});
        if (told.ok()) job_state = batch::ParseJobState(told->out);
      }
      record.reason = WithoutResult(record, job_state);
      record.state = CaptureState::kFailed;
      record.exit_code = kExitFailed;
      record.process = 0;
      record.ended_s = static_cast<std::int64_t>(NowSeconds());
    }
    state.captures[i] = std::move(record);
  }
}

Result<bool> RunOnSlurm(const batch::BatchFolder& folder,
                        const batch::BatchPlan& plan,
                        const SlurmArguments& arguments,
                        BatchDisplay& display,
                        batch::BatchState& state) {
  Result<Jobs> jobs = ReadJobs(folder);
  const Result<bool> at_work = jobs.ok() ? AskQueue(*jobs) : Result<bool>(false);
  if (!at_work.ok()) return at_work.error();
  if (*at_work) {
    if (!SamePlan(folder, plan)) {
      return Failed(fmt::format(
          "{}: jobs {} and {} of an earlier batch with other captures or options are at work here; "
          "wait for them, or stop them with scancel {} {}",
          folder.root.string(),
          jobs->array_id,
          jobs->summary_id,
          jobs->array_id,
          jobs->summary_id));
    }
    LogInfo(fmt::format("jobs {} and {} of this batch are at work; watching them",
                        jobs->array_id,
                        jobs->summary_id));
  } else {
    if (Status status = WritePlan(folder, plan); !status.ok()) return status.error();
    if (Status status = WriteWaitingRecords(folder, state); !status.ok()) return status.error();
    if (Status status = WriteBatchFile(folder, state); !status.ok()) return status.error();
    jobs = SubmitAll(folder, plan, arguments, state.jobs);
    if (!jobs.ok()) return jobs.error();
  }
  if (!arguments.wait) return false;
  if (Status status = Watch(folder, plan, *jobs, display, state).UntilEnd(); !status.ok())
    return status.error();
  return true;
}

}  // namespace deepslam::tools
