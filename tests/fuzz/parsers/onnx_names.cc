// The metadata entry `names` of a detector's ONNX file.
#include "deepslam/detect/yolo_heads.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(onnx_names) {
  const std::vector<std::string> names = detect::ParseNames(bytes);
  std::size_t size = 0;
  for (const std::string& name : names) size += name.size();
  DEEPSLAM_CHECK(size <= bytes.size(), "names come from the text");
  return !names.empty();
}
