// What a batch was asked to do, as its workers read it: a file in the batch's folder, so that workers
// on this machine and tasks on a cluster do the same.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"

namespace deepslam::batch {

struct PlannedCapture {
  std::filesystem::path path;
  std::string name;  // the workspace is ROOT/name
  friend bool operator==(const PlannedCapture&, const PlannedCapture&) = default;
};

struct BatchPlan {
  std::vector<PlannedCapture> captures;
  std::string run_options;  // text of a run.json: the options that differ from the defaults
  std::string until;        // last stage; empty: all
  bool keep_final = false;  // drop intermediate files of a capture that is done
  int num_threads = 0;      // of each worker; 0: all cores
  std::filesystem::path data_folder;
  friend bool operator==(const BatchPlan&, const BatchPlan&) = default;
};

[[nodiscard]] Result<std::string> EncodePlan(const BatchPlan& plan, std::string_view name);
[[nodiscard]] Result<BatchPlan> DecodePlan(std::string_view text, std::string_view name);

// Where things lie in a batch's folder; workspaces lie beside them.
struct BatchFolder {
  std::filesystem::path root;

  [[nodiscard]] std::filesystem::path batch_json() const { return root / "batch.json"; }
  [[nodiscard]] std::filesystem::path page() const { return root / "index.html"; }
  [[nodiscard]] std::filesystem::path internals() const { return root / ".batch"; }
  [[nodiscard]] std::filesystem::path plan() const { return internals() / "plan.json"; }
  [[nodiscard]] std::filesystem::path lock() const { return internals() / "lock"; }
  [[nodiscard]] std::filesystem::path jobs() const { return internals() / "jobs.json"; }
  [[nodiscard]] std::filesystem::path record(const std::string& name) const {
    return internals() / "records" / (name + ".json");
  }
  [[nodiscard]] std::filesystem::path log(const std::string& name) const {
    return internals() / "logs" / (name + ".log");
  }
};

}  // namespace deepslam::batch
