// The capture that benchmarks work on: the folder that DEEPSLAM_BENCH_CAPTURE names.
#pragma once

#include <cstdlib>
#include <string>

#include "deepslam/core/result.h"
#include "deepslam/dataset/capture.h"

namespace deepslam::bench {

inline Result<dataset::Capture> OpenNamedCapture() {
  const char* const folder =
      std::getenv("DEEPSLAM_BENCH_CAPTURE");  // NOLINT(concurrency-mt-unsafe)
  if (folder == nullptr)
    return InvalidConfig("DEEPSLAM_BENCH_CAPTURE: not set; name the folder of a capture");
  return dataset::OpenCapture(folder);
}

}  // namespace deepslam::bench
