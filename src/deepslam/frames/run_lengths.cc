#include "deepslam/frames/run_lengths.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <span>
#include <vector>

#include <fmt/format.h>

namespace deepslam {
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

std::string EncodeRuns(std::span<const std::int64_t> runs) {
  std::string text;
  for (std::size_t i = 0; i < runs.size(); ++i)
    AppendNumber(i > 2 ? runs[i] - runs[i - 2] : runs[i], text);
  text.shrink_to_fit();
  return text;
}

Status CheckSize(int width, int height) {
  if (width > 0 && height > 0 && width <= kMaxMaskPixels / height) return Ok();
  return InvalidInput(fmt::format("mask size {} x {} is out of range", width, height));
}

// Whether a run of `value` pixels fits behind `filled` ones.
Status CheckRun(std::size_t index, std::int64_t value, std::int64_t filled, int width, int height) {
  if (value >= 0 && value <= std::int64_t{width} * height - filled) return Ok();
  return InvalidInput(
      fmt::format("mask's run {} of {} pixels does not fit {} x {}", index, value, width, height));
}

Status CheckFilled(std::int64_t filled, int width, int height) {
  if (filled == std::int64_t{width} * height) return Ok();
  return InvalidInput(fmt::format("mask's runs cover {} pixels of {} x {}", filled, width, height));
}

// The runs, which fill the mask exactly; nothing as large as the mask is needed to know that.
Result<std::vector<std::int64_t>> DecodeRuns(std::string_view counts, int width, int height) {
  if (Status status = CheckSize(width, height); !status.ok()) return status.error();
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
    if (Status status = CheckRun(index, value, filled, width, height); !status.ok())
      return status.error();
    filled += value;
    runs.push_back(value);
  }
  if (Status status = CheckFilled(filled, width, height); !status.ok()) return status.error();
  return runs;
}

struct PixelPlace {
  int u = 0;
  int v = 0;
};

// Pixels whose value is not that of the pixel above, row by row; of all rows but the first.
std::vector<PixelPlace> ChangesWithinColumns(const Mask& mask) {
  // Pixels of one byte that a processor compares as one word.
  constexpr int kPixelsAtOnce = sizeof(std::uint64_t);
  std::vector<PixelPlace> changes;
  for (int v = 1; v < mask.height(); ++v) {
    const std::uint8_t* const above = mask.row(v - 1);
    const std::uint8_t* const row = mask.row(v);
    int u = 0;
    while (u < mask.width()) {
      if (u + kPixelsAtOnce <= mask.width() &&
          std::memcmp(row + u, above + u, kPixelsAtOnce) == 0) {
        u += kPixelsAtOnce;
        continue;
      }
      const int end = std::min(u + kPixelsAtOnce, mask.width());
      for (; u < end; ++u) {
        if ((row[u] != 0) != (above[u] != 0)) changes.push_back({u, v});
      }
    }
  }
  return changes;
}

// Where, counted column by column, the mask's value changes; from 0 before its first pixel.
std::vector<std::int64_t> ChangesByColumns(const Mask& mask) {
  const std::vector<PixelPlace> changes = ChangesWithinColumns(mask);
  const auto width = static_cast<std::size_t>(mask.width());
  std::vector<std::size_t> begin_of_column(width + 1, 0);
  for (const PixelPlace& change : changes)
    ++begin_of_column[static_cast<std::size_t>(change.u) + 1];
  std::uint8_t before = 0;
  for (int u = 0; u < mask.width(); ++u) {
    const bool at_top = (mask(u, 0) != 0) != (before != 0);
    begin_of_column[static_cast<std::size_t>(u) + 1] += at_top ? 1 : 0;
    before = mask(u, mask.height() - 1);
  }
  std::partial_sum(begin_of_column.begin(), begin_of_column.end(), begin_of_column.begin());
  std::vector<std::int64_t> places(begin_of_column.back());
  std::vector<std::size_t> next(begin_of_column.begin(), begin_of_column.end() - 1);
  before = 0;
  for (int u = 0; u < mask.width(); ++u) {
    if ((mask(u, 0) != 0) != (before != 0))
      places[next[static_cast<std::size_t>(u)]++] = std::int64_t{u} * mask.height();
    before = mask(u, mask.height() - 1);
  }
  for (const PixelPlace& change : changes) {
    places[next[static_cast<std::size_t>(change.u)]++] =
        std::int64_t{change.u} * mask.height() + change.v;
  }
  return places;
}

// Pixels from `begin` to `end`, counted column by column.
void SetPixels(std::int64_t begin, std::int64_t end, Mask& mask) {
  while (begin < end) {
    const auto u = static_cast<int>(begin / mask.height());
    const auto v = static_cast<int>(begin % mask.height());
    const auto v_end = static_cast<int>(std::min<std::int64_t>(mask.height(), v + end - begin));
    std::uint8_t* pixel = &mask(u, v);
    *pixel = 1;
    for (int k = v + 1; k < v_end; ++k) *(pixel += mask.width()) = 1;
    begin += v_end - v;
  }
}

}  // namespace

std::string EncodeRle(const Mask& mask) {
  std::vector<std::int64_t> runs;
  if (!mask.empty()) runs = ChangesByColumns(mask);
  runs.push_back(static_cast<std::int64_t>(mask.size()));
  std::adjacent_difference(runs.begin(), runs.end(), runs.begin());
  return EncodeRuns(runs);
}

Result<std::string> RleOfRuns(std::span<const std::int64_t> runs, int width, int height) {
  if (Status status = CheckSize(width, height); !status.ok()) return status.error();
  std::int64_t filled = 0;
  for (std::size_t index = 0; index < runs.size(); ++index) {
    if (Status status = CheckRun(index, runs[index], filled, width, height); !status.ok())
      return status.error();
    filled += runs[index];
  }
  if (Status status = CheckFilled(filled, width, height); !status.ok()) return status.error();
  return EncodeRuns(runs);
}

Result<std::string> CanonicalRle(std::string_view counts, int width, int height) {
  const Result<std::vector<std::int64_t>> runs = DecodeRuns(counts, width, height);
  if (!runs.ok()) return runs.error();
  std::vector<std::int64_t> joined;
  for (std::size_t index = 0; index < runs->size(); ++index) {
    const std::int64_t run = (*runs)[index];
    if (index > 0 && run == 0) continue;
    if (joined.size() % 2 == index % 2) {
      joined.push_back(run);
    } else {  // of the value of the last one, as what lay between was empty
      joined.back() += run;
    }
  }
  return EncodeRuns(joined);
}

Result<Mask> DecodeRle(std::string_view counts, int width, int height) {
  const Result<std::vector<std::int64_t>> runs = DecodeRuns(counts, width, height);
  if (!runs.ok()) return runs.error();
  Mask mask(width, height);
  std::int64_t filled = 0;
  for (std::size_t index = 0; index < runs->size(); ++index) {
    const std::int64_t end = filled + (*runs)[index];
    if (index % 2 == 1) SetPixels(filled, end, mask);
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

}  // namespace deepslam
