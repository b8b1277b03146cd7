// DEEPSLAM_WIDE_VECTORS before a function: it and everything it calls in its file are compiled for
// processors with AVX2 as well, and the program takes the form that fits when it starts. The
// numbers are the same to the bit: AVX2 brings wider vectors without fused multiply-add, and sums
// are written in a fixed number of partial ones.
//
// Nothing where the compiler or the C library cannot choose a function at start (clang 14 has no
// clones that are flattened), and under sanitizers, which are not ready when that choice is made.
#pragma once

#include <cstddef>  // defines __GLIBC__ where there is one

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || \
    __has_feature(memory_sanitizer)
#define DEEPSLAM_SANITIZED 1
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define DEEPSLAM_SANITIZED 1
#endif

#if defined(__x86_64__) && defined(__GLIBC__) && !defined(DEEPSLAM_SANITIZED) && \
    !defined(__clang__) && __has_attribute(target_clones)
#define DEEPSLAM_WIDE_VECTORS __attribute__((target_clones("avx2", "default"), flatten))
#else
#define DEEPSLAM_WIDE_VECTORS
#endif
