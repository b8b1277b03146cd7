// Options that there were and whose values are fixed now: who still sets one is told so, with the
// value that holds.
#pragma once

#include <string_view>

#include "deepslam/core/options.h"

namespace deepslam::stages {

// Passes those of a section ("loops.appearance") to the visitor as retired.
void DescribeRetired(std::string_view section, OptionsVisitor& visitor);

}  // namespace deepslam::stages
