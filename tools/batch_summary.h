// batch.json and the page over all captures.
#pragma once

#include "deepslam/batch/batch_plan.h"
#include "deepslam/batch/batch_state.h"
#include "deepslam/core/result.h"

namespace deepslam::tools {

[[nodiscard]] Status WriteBatchFile(const batch::BatchFolder& folder,
                                    const batch::BatchState& state);
// index.html, with thumbnails out of the workspaces.
[[nodiscard]] Status WriteBatchPage(const batch::BatchFolder& folder,
                                    const batch::BatchState& state);

}  // namespace deepslam::tools
