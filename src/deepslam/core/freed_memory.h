// Memory that was let go: how much of it stays with the process.
//
// A run makes and drops images and grids of a megabyte all the time. Given back to the system at
// once, each comes again as fresh pages, cleared one by one: a twentieth of a run's processor time.
// Results do not depend on it. Where the C library is not glibc, both do nothing.
#pragma once

#include <cstddef>

namespace deepslam {

// To be called once, before there are threads: what is let go may be used again at once.
void KeepFreedMemory();

// What a run lets go stays for what comes next up to here. Beyond, the capture is a long one whose
// stages each need their memory for themselves.
inline constexpr std::size_t kMostHeldBytes = std::size_t{320} << 20;

// Gives back what is free if that and what is in use are more than `most_bytes` together.
void ReturnFreedMemory(std::size_t most_bytes);

}  // namespace deepslam
