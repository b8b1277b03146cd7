// A person's corrections of which detections are one object, and of what class it is.
#pragma once

#include <string>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/overrides.h"

namespace deepslam::overrides {

// Split, then merge, relabel, drop; sub-tracks of a split object get the next free ids, in the
// order of the file. The detections of dropped objects become rejections. Returns one sentence per
// correction applied; errors (kInvalidConfig) name file, line and what is known.
[[nodiscard]] Result<std::vector<std::string>> ApplyToTracks(const Overrides& overrides,
                                                             const ClassTable& classes,
                                                             Association& association);

}  // namespace deepslam::overrides
