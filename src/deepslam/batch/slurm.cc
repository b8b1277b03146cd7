#include "deepslam/batch/slurm.h"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

namespace deepslam::batch {
namespace {

constexpr int kDefaultMaxArraySize = 1001;  // Slurm's own, where its configuration says nothing

bool IsNumber(std::string_view text) {
  return !text.empty() &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

std::string_view FirstLine(std::string_view text) { return text.substr(0, text.find('\n')); }

// The word behind "KEY=".
std::string_view ValueOf(std::string_view text, std::string_view key) {
  const std::size_t at = text.find(key);
  if (at == std::string_view::npos) return {};
  text.remove_prefix(at + key.size());
  return text.substr(0, text.find_first_of(" \t\n"));
}

std::vector<std::string> Common(const SlurmBatch& batch, const std::string& job_name) {
  std::vector<std::string> words = {"sbatch", "--parsable", "--job-name=" + job_name, "--ntasks=1"};
  if (!batch.options.partition.empty()) words.push_back("--partition=" + batch.options.partition);
  words.push_back("--requeue");
  words.emplace_back("--open-mode=append");
  return words;
}

void AddMore(const SlurmBatch& batch, std::vector<std::string>& words) {
  words.insert(words.end(), batch.options.more.begin(), batch.options.more.end());
}

std::string JobName(const SlurmBatch& batch) {
  return "deepslam-" + batch.root.filename().string();
}

}  // namespace

int CapturesPerTask(int num_captures, int max_tasks) {
  return std::max(1, (num_captures + max_tasks - 1) / std::max(1, max_tasks));
}

std::string_view SlurmTaskScript() {
  return "#!/bin/sh\n"
         "# One task of a batch: deepslam, folder of the batch, captures per task.\n"
         "exec \"$1\" batch-worker \"$2\" --task \"$SLURM_ARRAY_TASK_ID\" --per-task \"$3\"\n";
}

std::vector<std::string> SubmitArray(const SlurmBatch& batch) {
  const int num_tasks = (batch.num_captures + batch.per_task - 1) / batch.per_task;
  std::vector<std::string> words = Common(batch, JobName(batch));
  std::string array = fmt::format("--array=0-{}", num_tasks - 1);
  if (batch.at_a_time > 0) array += fmt::format("%{}", batch.at_a_time);
  words.push_back(array);
  words.push_back(fmt::format("--cpus-per-task={}", batch.num_threads));
  if (!batch.options.time.empty()) words.push_back("--time=" + batch.options.time);
  if (!batch.options.memory.empty()) words.push_back("--mem=" + batch.options.memory);
  words.push_back("--output=" + (batch.root / ".batch" / "logs" / "slurm-%A_%a.log").string());
  AddMore(batch, words);
  words.insert(words.end(),
               {batch.script.string(),
                batch.program.string(),
                batch.root.string(),
                std::to_string(batch.per_task)});
  return words;
}

std::vector<std::string> SubmitSummary(const SlurmBatch& batch, const std::string& array_id) {
  std::vector<std::string> words = Common(batch, JobName(batch) + "-summary");
  words.push_back("--dependency=afterany:" + array_id);
  words.push_back("--output=" + (batch.root / ".batch" / "logs" / "slurm-summary-%j.log").string());
  AddMore(batch, words);
  words.insert(words.end(),
               {(batch.script.parent_path() / "summary.sh").string(),
                batch.program.string(),
                batch.root.string()});
  return words;
}

Result<std::string> ParseJobId(std::string_view output) {
  std::string_view id = FirstLine(output);
  id = id.substr(0, id.find(';'));
  if (!IsNumber(id))
    return Failed(fmt::format("sbatch answered '{}', which names no job", FirstLine(output)));
  return std::string(id);
}

bool AnyInQueue(std::string_view squeue_output, std::span<const std::string> ids) {
  while (!squeue_output.empty()) {
    std::string_view line = FirstLine(squeue_output);
    squeue_output.remove_prefix(std::min(squeue_output.size(), line.size() + 1));
    while (!line.empty() && (line.back() == ' ' || line.back() == '\r')) line.remove_suffix(1);
    if (std::find(ids.begin(), ids.end(), line) != ids.end()) return true;
  }
  return false;
}

int ParseMaxArraySize(std::string_view config) {
  const std::size_t at = config.find("MaxArraySize");
  if (at == std::string_view::npos) return kDefaultMaxArraySize;
  config = FirstLine(config.substr(at));
  const std::size_t digit = config.find_first_of("0123456789");
  int size = 0;
  if (digit == std::string_view::npos ||
      std::from_chars(config.data() + digit, config.data() + config.size(), size).ec !=
          std::errc() ||
      size < 2) {
    return kDefaultMaxArraySize;
  }
  return size;
}

std::string ParseJobState(std::string_view job) {
  const std::string_view state = ValueOf(job, "JobState=");
  const std::string_view reason = ValueOf(job, "Reason=");
  if (state.empty()) return {};
  if (reason.empty() || reason == "None" || reason == "(null)") return std::string(state);
  return fmt::format("{} ({})", state, reason);
}

}  // namespace deepslam::batch
