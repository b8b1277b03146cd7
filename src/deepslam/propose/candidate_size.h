// The range of real sizes that a candidate may take.
#pragma once

#include <algorithm>

#include "deepslam/scene/object_class.h"
#include "deepslam/scene/shape_candidate.h"

namespace deepslam::propose {

// size_m, and size_m +- margin cut to the class's range; the class's range is dropped where the two
// do not meet, since then the class is more doubtful than the measurement.
inline void SetSize(double size_m,
                    double margin,
                    const ObjectClass* object_class,
                    ShapeCandidate& candidate) {
  candidate.size_m = size_m;
  candidate.min_size_m = size_m * (1.0 - margin);
  candidate.max_size_m = size_m * (1.0 + margin);
  if (object_class == nullptr) return;
  const double low = std::max(candidate.min_size_m, object_class->min_size_m);
  const double high = std::min(candidate.max_size_m, object_class->max_size_m);
  if (low >= high) return;
  candidate.min_size_m = low;
  candidate.max_size_m = high;
  candidate.size_m = std::clamp(size_m, low, high);
}

}  // namespace deepslam::propose
