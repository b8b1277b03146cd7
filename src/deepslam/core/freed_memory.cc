#include "deepslam/core/freed_memory.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace deepslam {

#ifdef __GLIBC__

void KeepFreedMemory() {
  constexpr int kLargestInHeap = 32 << 20;  // glibc takes no more
  constexpr int kMostFreeAtItsEnd = 128 << 20;
  ::mallopt(M_MMAP_THRESHOLD, kLargestInHeap);
  ::mallopt(M_TRIM_THRESHOLD, kMostFreeAtItsEnd);
}

void ReturnFreedMemory(std::size_t most_kept_bytes) {
  if (::mallinfo2().fordblks > most_kept_bytes) ::malloc_trim(0);
}

#else

void KeepFreedMemory() {}
void ReturnFreedMemory(std::size_t /*most_kept_bytes*/) {}

#endif

}  // namespace deepslam
