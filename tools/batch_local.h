// The engine on this machine: worker processes that take one capture after another.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "batch_display.h"
#include "deepslam/batch/batch_plan.h"
#include "deepslam/batch/batch_state.h"
#include "deepslam/core/result.h"

namespace deepslam::tools {

// Runs captures of the plan that lies in the folder: `state` holds those, and `indices` their
// places in the plan. `save` is called whenever the state changed. Processes rather than threads: a
// capture that crashes, or takes all memory, ends its own process and no other. Stops on SIGINT and
// SIGTERM (kInterrupted); captures are then waiting or interrupted.
[[nodiscard]] Status RunLocally(const batch::BatchFolder& folder,
                                const std::vector<std::size_t>& indices,
                                const std::function<Status()>& save,
                                BatchDisplay& display,
                                batch::BatchState& state);

}  // namespace deepslam::tools
