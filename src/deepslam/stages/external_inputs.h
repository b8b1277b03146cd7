// What stages take from outside the workspace, as their keys have it: hashes of its content.
#pragma once

#include <map>
#include <string>

#include "deepslam/core/result.h"
#include "deepslam/stages/plan.h"

namespace deepslam::stages {

// Added up.
enum External : unsigned {
  kNothing = 0,
  kFrames = 1,
  kClasses = 2,
  kDetector = 4,
  kLibrary = 8,
  // parts of overrides.yaml
  kGroundHint = 16,
  kTrackOverrides = 32,
  kChoices = 64,
  kPriors = 128,
  kExportColumns = 256,  // kClasses with what stage `export` alone asks of classes
};

// By name. Parts of the corrections that are empty have none. Errors name what is missing, and what
// to run.
[[nodiscard]] Result<std::map<std::string, std::string>> HashExternals(const RunInputs& inputs,
                                                                       unsigned what);

}  // namespace deepslam::stages
