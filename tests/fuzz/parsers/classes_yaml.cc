// The table of object classes.
#include "deepslam/artifact/class_table_yaml.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(classes_yaml) {
  return RoundTrip(
      bytes, artifact::DecodeClassTable, [](const ClassTable& table, std::string_view) {
        return Result<std::string>(artifact::EncodeClassTable(table));
      });
}
