// DEEPSLAM_CHECK(condition, message): a breach is a bug in this program; prints place and message,
// then aborts.
#pragma once

#include <string_view>

namespace deepslam {

[[noreturn]] void AbortOnBug(std::string_view condition,
                             std::string_view message,
                             std::string_view file,
                             int line);

}  // namespace deepslam

#define DEEPSLAM_CHECK(condition, message)                               \
  do {                                                                   \
    if (!(condition)) {                                                  \
      ::deepslam::AbortOnBug(#condition, (message), __FILE__, __LINE__); \
    }                                                                    \
  } while (false)
