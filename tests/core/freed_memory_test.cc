#include "deepslam/core/freed_memory.h"

#include <unistd.h>

#include <cstddef>
#include <fstream>
#include <vector>

#include <gtest/gtest.h>

namespace deepslam {
namespace {

constexpr std::size_t kMib = std::size_t{1} << 20;

std::size_t ResidentBytes() {
  std::ifstream statm("/proc/self/statm");  // proc(5): size, then resident, in pages
  std::size_t all = 0;
  std::size_t resident = 0;
  statm >> all >> resident;
  return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

// 48 pieces of a MiB come and go.
void UseAndLetGo() {
  std::vector<std::vector<char>> images;
  for (int n = 0; n < 48; ++n) images.emplace_back(kMib, static_cast<char>(n));
}

TEST(FreedMemory, StaysUntilThereIsTooMuchOfIt) {
  KeepFreedMemory();
  UseAndLetGo();
  const std::size_t used = ResidentBytes();
  ASSERT_GE(used, 48 * kMib);
  ReturnFreedMemory(256 * kMib);
  EXPECT_GE(ResidentBytes() + 8 * kMib, used);
  ReturnFreedMemory(16 * kMib);
  EXPECT_LE(ResidentBytes() + 32 * kMib, used);
}

}  // namespace
}  // namespace deepslam
