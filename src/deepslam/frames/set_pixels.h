// The pixels of a mask's row that are set, found eight at a time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace deepslam {

// The first one that is not 0; `end` where there is none.
[[nodiscard]] inline const std::uint8_t* FirstSet(const std::uint8_t* begin,
                                                  const std::uint8_t* end) {
  std::uint64_t word = 0;
  for (; end - begin >= static_cast<std::ptrdiff_t>(sizeof(word)); begin += sizeof(word)) {
    std::memcpy(&word, begin, sizeof(word));
    if (word != 0) break;
  }
  return std::find_if(begin, end, [](std::uint8_t pixel) { return pixel != 0; });
}

}  // namespace deepslam
