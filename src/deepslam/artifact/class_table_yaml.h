// configs/classes.yaml: the table of object classes.
#pragma once

#include <string>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/scene/object_class.h"

namespace deepslam::artifact {

// The table compiled in; configs/classes.yaml holds the same (a test compares).
[[nodiscard]] ClassTable DefaultClassTable();

[[nodiscard]] std::string EncodeClassTable(const ClassTable& table);
// All faults at once, each with its line: unknown keys, sizes out of range, names and labels given
// twice.
[[nodiscard]] Result<ClassTable> DecodeClassTable(std::string_view text, std::string_view name);

}  // namespace deepslam::artifact
