// Whether a stage's files still are what its function would make now, and if not, why.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "deepslam/pipeline/manifest.h"
#include "deepslam/pipeline/stage.h"

namespace deepslam::pipeline {

struct Decision {
  std::vector<std::string> reasons;  // why it must run; empty: its files stand
  bool missing = false;              // it never ran to its end here
  bool dropped = false;              // it stands, but its files were dropped (drop.h)
  std::optional<Manifest> manifest;  // of the files that lie there, sound or not
};

// The manifest a run with these inputs would write, outputs and summary left empty.
[[nodiscard]] Manifest Expected(const Stage& stage,
                                std::map<std::string, std::string> inputs,
                                std::map<std::string, std::string> external_inputs);

// Compares what lies in WORKSPACE/<stage> with `expected`, and every output's bytes with the
// manifest's hash.
[[nodiscard]] Decision Decide(const std::filesystem::path& workspace, const Manifest& expected);

// Readable differences ("option detect.min_score 0.3 -> 0.4", "input segment changed").
[[nodiscard]] std::vector<std::string> Differences(const Manifest& old_manifest,
                                                   const Manifest& expected);

}  // namespace deepslam::pipeline
