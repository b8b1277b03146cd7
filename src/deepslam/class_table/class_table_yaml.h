// configs/classes.yaml: the table of object classes.
#pragma once

#include <string>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/scene/object_class.h"

namespace deepslam::class_table {

// The table compiled in; configs/classes.yaml holds the same (a test compares).
[[nodiscard]] ClassTable DefaultClassTable();

[[nodiscard]] std::string EncodeClassTable(const ClassTable& table);
// All faults at once, each with its line, its class and its field: unknown keys, sizes out of
// range, traits and supports that are none, names and labels given twice, two fallbacks, a
// version that is to come. Traits that are left out are false; a table of version 1 knows none, and
// its classes have those that programs of that version gave them by name (`table`, `furniture`,
// ...).
[[nodiscard]] Result<ClassTable> DecodeClassTable(std::string_view text, std::string_view name);

}  // namespace deepslam::class_table
