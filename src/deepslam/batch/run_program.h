// Another program, run to its end.
#pragma once

#include <string>
#include <vector>

#include "deepslam/core/result.h"

namespace deepslam::batch {

struct ProgramOutput {
  int exit_code = 0;  // 128 + n where signal n killed it
  std::string out;
  std::string err;
};

// Looks for the program in PATH; no shell is involved. kFailed when it cannot be started.
[[nodiscard]] Result<ProgramOutput> RunProgram(const std::vector<std::string>& command);

// Whether PATH has it.
[[nodiscard]] bool HasProgram(const std::string& name);

}  // namespace deepslam::batch
