// One capture of a batch, in a worker process: the run, its log, its record.
#pragma once

#include <functional>
#include <memory>

#include "deepslam/batch/batch_plan.h"
#include "deepslam/batch/capture_record.h"
#include "deepslam/core/result.h"
#include "deepslam/stages/config.h"
#include "deepslam/stages/content_hashes.h"
#include "deepslam/stages/model_cache.h"

namespace deepslam::tools {

// What the captures of a worker share.
struct BatchWork {
  batch::BatchFolder folder;
  batch::BatchPlan plan;
  stages::Config config;
  std::shared_ptr<stages::ModelCache> models;
  std::shared_ptr<stages::ContentHashes> hashes;
};

// Reads the plan in a batch's folder.
[[nodiscard]] Result<BatchWork> ReadWork(const std::filesystem::path& root);

// Writes the plan, and makes the folders of records and logs.
[[nodiscard]] Status WritePlan(const batch::BatchFolder& folder, const batch::BatchPlan& plan);

// Runs capture `index` of the plan as `deepslam run` would, with standard error in its log, and
// writes its record, first as running and last as it ended. `changed` hears of each new stage and,
// now and then, of its steps. The record that comes back says how it ended; a failed capture is no
// error.
[[nodiscard]] Result<batch::CaptureRecord> RunPlanned(
    const BatchWork& work,
    std::size_t index,
    const std::function<void(const batch::CaptureRecord&)>& changed);

// The record of a capture, or a waiting one where there is none that can be read.
[[nodiscard]] batch::CaptureRecord ReadRecordOf(const batch::BatchFolder& folder,
                                                const batch::PlannedCapture& capture);
[[nodiscard]] Status WriteRecord(const batch::BatchFolder& folder,
                                 const batch::CaptureRecord& record);

// Seconds since 1970.
[[nodiscard]] double NowSeconds();

}  // namespace deepslam::tools
