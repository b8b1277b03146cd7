#include "deepslam/core/check.h"

#include <cstdio>
#include <cstdlib>

namespace deepslam {

void AbortOnBug(std::string_view condition,
                std::string_view message,
                std::string_view file,
                int line) {
  std::fprintf(stderr,
               "deepslam: bug at %.*s:%d: %.*s: %.*s\n",
               static_cast<int>(file.size()),
               file.data(),
               line,
               static_cast<int>(condition.size()),
               condition.data(),
               static_cast<int>(message.size()),
               message.data());
  std::abort();
}

}  // namespace deepslam
