// The engine on a cluster: an array of Slurm jobs, and one for the summary.
#pragma once

#include "batch_display.h"
#include "deepslam/batch/batch_plan.h"
#include "deepslam/batch/batch_state.h"
#include "deepslam/batch/slurm.h"
#include "deepslam/core/result.h"

namespace deepslam::tools {

struct SlurmArguments {
  batch::SlurmOptions options;
  int per_task = 0;  // captures of one task; 0: one, or as many as make the array fit
  bool wait = true;
};

// kInvalidConfig with a remedy where Slurm's programs are missing.
[[nodiscard]] Status CheckSlurm();

// Submits the batch, whose plan lies in the folder, or takes up watching where its jobs are still
// at work; then waits for their end and keeps `state` and batch.json up to date. False: submitted,
// and not waited for. SIGINT and SIGTERM cancel the jobs.
[[nodiscard]] Result<bool> RunOnSlurm(const batch::BatchFolder& folder,
                                      const batch::BatchPlan& plan,
                                      const SlurmArguments& arguments,
                                      BatchDisplay& display,
                                      batch::BatchState& state);

// Reads all records; where the jobs are over, one that has not ended is a failure.
void GatherRecords(const batch::BatchFolder& folder,
                   const batch::BatchPlan& plan,
                   bool jobs_are_over,
                   batch::BatchState& state);

}  // namespace deepslam::tools
