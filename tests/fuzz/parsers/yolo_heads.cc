// The shapes and numbers that a detector's network gives: first the number of names, how many
// outputs and their shapes, then the first output's values.
#include <cstdint>
#include <cstring>
#include <vector>

#include "deepslam/detect/yolo_heads.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(yolo_heads) {
  std::size_t at = 0;
  const auto byte = [&] { return at < bytes.size() ? static_cast<std::uint8_t>(bytes[at++]) : 0U; };
  const int num_names = static_cast<int>(byte());
  std::vector<std::vector<std::int64_t>> shapes(byte() % 4);
  for (auto& shape : shapes) {
    shape.resize(byte() % 5);
    for (std::int64_t& side : shape) {
      side = static_cast<std::int8_t>(byte());
      // Sides beyond a byte's reach, and those that no memory holds.
      if (side > 120) side = std::int64_t{1} << (side % 64);
    }
  }
  const auto layout = detect::RecogniseHead(shapes, num_names, 64, 64);
  if (!layout.ok()) return false;
  std::size_t count = 1;
  for (const std::int64_t side : shapes[0]) count *= static_cast<std::size_t>(side);
  constexpr std::size_t kMostValues = 1 << 20;
  if (count > kMostValues) return true;
  std::vector<float> output(count);
  for (float& value : output) {
    if (at + sizeof(float) > bytes.size()) break;
    std::memcpy(&value, bytes.data() + at, sizeof(float));
    at += sizeof(float);
  }
  for (const detect::HeadBox& box :
       detect::SuppressOverlaps(detect::DecodeHead(output, *layout, 0.1), 0.6, 100)) {
    DEEPSLAM_CHECK(box.label_idx >= 0 && box.label_idx < layout->num_classes, "a label has a name");
    (void)detect::ToImage(
        detect::FitLetterbox(33, 21, 64, 64, detect::Padding::kCentred), box.box_input, 33, 21);
  }
  return true;
}
