// What sbatch, scontrol and squeue answer.
#include "deepslam/batch/slurm.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(slurm_answers) {
  const Result<std::string> id = batch::ParseJobId(bytes);
  (void)batch::ParseMaxArraySize(bytes);
  (void)batch::ParseJobState(bytes);
  return id.ok();
}
