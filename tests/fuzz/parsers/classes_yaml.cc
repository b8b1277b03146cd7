// The table of object classes.
#include "deepslam/class_table/class_table_yaml.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(classes_yaml) {
  return RoundTrip(
      bytes, class_table::DecodeClassTable, [](const ClassTable& table, std::string_view) {
        return Result<std::string>(class_table::EncodeClassTable(table));
      });
}
