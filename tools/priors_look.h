// `deepslam priors look`.
#pragma once

#include "commands.h"

namespace deepslam::tools {

void AddPriorsLook(CLI::App& priors, Command& chosen);

}  // namespace deepslam::tools
