// A record inside a larger document.
#pragma once

#include "deepslam/artifact/json_reader.h"
#include "deepslam/batch/capture_record.h"

namespace deepslam::batch {

// Faults are noted in the node's reader.
[[nodiscard]] CaptureRecord ReadRecord(const artifact::JsonNode& row);

}  // namespace deepslam::batch
