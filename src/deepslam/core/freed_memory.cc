#include "deepslam/core/freed_memory.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace deepslam {

#ifdef __GLIBC__

void KeepFreedMemory() {
  constexpr int kLargestInHeap = 32 << 20;               // glibc takes no more
  constexpr int kMostFreeAtItsEnd = 2 * kLargestInHeap;  // as glibc would have it
  ::mallopt(M_MMAP_THRESHOLD, kLargestInHeap);
  ::mallopt(M_TRIM_THRESHOLD, kMostFreeAtItsEnd);
}

void ReturnFreedMemory(std::size_t most_bytes) {
  const struct mallinfo2 held = ::mallinfo2();
  if (held.arena + held.hblkhd > most_bytes) ::malloc_trim(0);
}

#else

void KeepFreedMemory() {}
void ReturnFreedMemory(std::size_t /*most_bytes*/) {}

#endif

}  // namespace deepslam
