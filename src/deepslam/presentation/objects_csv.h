// objects.csv: the object list for spreadsheets.
#pragma once

#include <span>
#include <string>

#include "deepslam/scene/compact_map.h"

namespace deepslam::presentation {

// One row per object: name, class, size along its axes, volume, place of its centre, heading,
// confidence, source. `volumes_m3` has one entry per object. Text fields are quoted; a field that a
// spreadsheet would run as a formula is preceded by an apostrophe.
[[nodiscard]] std::string EncodeObjectsCsv(std::span<const CompactObject> objects,
                                           std::span<const double> volumes_m3);

}  // namespace deepslam::presentation
