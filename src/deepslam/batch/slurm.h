// What is said to Slurm, and what it says. Nothing here schedules: sbatch, squeue, scancel and
// scontrol do.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"

namespace deepslam::batch {

struct SlurmOptions {
  std::string partition;  // empty: the cluster's default, as for the others
  std::string time;       // of one task: "02:00:00"
  std::string memory;     // of one task: "4G"
  std::vector<std::string> more;  // further arguments of sbatch, as they are
};

struct SlurmBatch {
  std::filesystem::path root;     // on a file system that all nodes see
  std::filesystem::path program;  // deepslam, likewise
  std::filesystem::path script;   // of a task: SlurmTaskScript
  int num_captures = 0;
  int per_task = 1;   // captures that one task takes, one after another
  int at_a_time = 0;  // tasks; 0: as many as the cluster takes
  int num_threads = 1;
  SlurmOptions options;
};

// Fewest captures per task so that the array has no more than `max_tasks` tasks.
[[nodiscard]] int CapturesPerTask(int num_captures, int max_tasks);

// The script that the array's tasks run; its arguments are the program, the batch's folder and the
// captures per task.
[[nodiscard]] std::string_view SlurmTaskScript();

// sbatch for the array: tasks of lost nodes are queued again (--requeue) and continue where the
// workspace stands.
[[nodiscard]] std::vector<std::string> SubmitArray(const SlurmBatch& batch);
// sbatch for the summary: after all tasks have ended, however they did.
[[nodiscard]] std::vector<std::string> SubmitSummary(const SlurmBatch& batch,
                                                     const std::string& array_id);

// The id in what `sbatch --parsable` prints ("123" or "123;cluster").
[[nodiscard]] Result<std::string> ParseJobId(std::string_view output);

// Whether any of the jobs stands in what `squeue -h -o %F` prints.
[[nodiscard]] bool AnyInQueue(std::string_view squeue_output, std::span<const std::string> ids);

// MaxArraySize in what `scontrol show config` prints; Slurm's default where it does not say.
[[nodiscard]] int ParseMaxArraySize(std::string_view config);

// JobState and Reason in what `scontrol show job -o` prints: "OUT_OF_MEMORY", "NODE_FAIL", or
// "TIMEOUT (TimeLimit)". Empty where it does not say.
[[nodiscard]] std::string ParseJobState(std::string_view job);

}  // namespace deepslam::batch
