#include "deepslam/artifact/rle.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include <fmt/format.h>

namespace deepslam::artifact {
namespace {

// Five bits per character, sign-extended, from '0' on; from the third run on the difference to the
// run two before.
void AppendNumber(std::int64_t value, std::string& text) {
  bool more = true;
  while (more) {
    int bits = static_cast<int>(value & 0x1f);
    value >>= 5;
    more = (bits & 0x10) != 0 ? value != -1 : value != 0;
    if (more) bits |= 0x20;
    text += static_cast<char>(bits + 48);
  }
}

// The runs, which fill the mask exactly; nothing as large as the mask is needed to know that.
Result<std::vector<std::int64_t>> DecodeRuns(std::string_view counts, int width, int height) {
  if (width <= 0 || height <= 0 || width > kMaxMaskPixels / height) {
    return InvalidInput(fmt::format("mask size {} x {} is out of range", width, height));
  }
  const std::int64_t total = static_cast<std::int64_t>(width) * height;
  std::vector<std::int64_t> runs;
  std::int64_t filled = 0;
  std::size_t at = 0;
  while (at < counts.size()) {
    std::int64_t value = 0;
    int shift = 0;
    bool more = true;
    while (more) {
      if (at >= counts.size() || shift > 35)
        return InvalidInput("mask's run lengths are cut off or too long");
      const int bits = counts[at++] - 48;
      if (bits < 0 || bits > 63)
        return InvalidInput("mask's run lengths hold a character outside the COCO code");
      value |= static_cast<std::int64_t>(bits & 0x1f) << shift;
      shift += 5;
      more = (bits & 0x20) != 0;
      if (!more && (bits & 0x10) != 0) value |= -(std::int64_t{1} << shift);
    }
    const std::size_t index = runs.size();
    if (index > 2) value += runs[index - 2];
    if (value < 0 || value > total - filled) {
      return InvalidInput(fmt::format(
          "mask's run {} of {} pixels does not fit {} x {}", index, value, width, height));
    }
    filled += value;
    runs.push_back(value);
  }
  if (filled != total) {
    return InvalidInput(
        fmt::format("mask's runs cover {} pixels of {} x {}", filled, width, height));
  }
  return runs;
}

}  // namespace

std::string EncodeRle(const Mask& mask) {
  std::vector<std::int64_t> runs;
  std::int64_t run = 0;
  bool current = false;
  for (int u = 0; u < mask.width(); ++u) {
    for (int v = 0; v < mask.height(); ++v) {
      const bool set = mask(u, v) != 0;
      if (set != current) {
        runs.push_back(run);
        run = 0;
        current = set;
      }
      ++run;
    }
  }
  runs.push_back(run);
  std::string text;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    AppendNumber(i > 2 ? runs[i] - runs[i - 2] : runs[i], text);
  }
  return text;
}

Result<Mask> DecodeRle(std::string_view counts, int width, int height) {
  const Result<std::vector<std::int64_t>> runs = DecodeRuns(counts, width, height);
  if (!runs.ok()) return runs.error();
  Mask mask(width, height);
  std::int64_t filled = 0;
  for (std::size_t index = 0; index < runs->size(); ++index) {
    const std::int64_t end = filled + (*runs)[index];
    if (index % 2 == 1) {
      for (std::int64_t p = filled; p < end; ++p)
        mask(static_cast<int>(p / height), static_cast<int>(p % height)) = 1;
    }
    filled = end;
  }
  return mask;
}

Result<Mask> DecodeRleResized(
    std::string_view counts, int width, int height, int out_width, int out_height) {
  Result<std::vector<std::int64_t>> ends = DecodeRuns(counts, width, height);
  if (!ends.ok()) return ends.error();
  std::partial_sum(ends->begin(), ends->end(), ends->begin());
  const auto at_centre = [](int out, int size, int out_size) {
    return (2 * std::int64_t{out} + 1) * size / (2 * std::int64_t{out_size});
  };
  Mask mask(out_width, out_height);
  auto run = ends->begin();
  std::int64_t run_begin = 0;
  for (int u = 0; u < out_width; ++u) {
    const std::int64_t column = at_centre(u, width, out_width) * height;
    for (int v = 0; v < out_height; ++v) {
      const std::int64_t p = column + at_centre(v, height, out_height);
      if (p < run_begin || p >= *run) {
        run = std::upper_bound(ends->begin(), ends->end(), p);
        run_begin = run == ends->begin() ? 0 : *(run - 1);
      }
      mask(u, v) = (run - ends->begin()) % 2 == 1 ? 1 : 0;
    }
  }
  return mask;
}

}  // namespace deepslam::artifact
