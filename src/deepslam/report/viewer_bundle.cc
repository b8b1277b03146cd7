#include "deepslam/report/viewer_bundle.h"

#ifdef DEEPSLAM_VIEWER_JS
// A megabyte as a string literal would cost compilers minutes and memory; the assembler just copies
// it.
asm(".section .rodata\n"
    "deepslam_viewer_begin: .incbin \"" DEEPSLAM_VIEWER_JS
    "\"\n"
    "deepslam_viewer_end:\n"
    ".globl deepslam_viewer_begin\n.hidden deepslam_viewer_begin\n"
    ".globl deepslam_viewer_end\n.hidden deepslam_viewer_end\n"
    ".text\n");
extern "C" {
extern const char deepslam_viewer_begin[];
extern const char deepslam_viewer_end[];
}
#endif

namespace deepslam::report {

std::string_view ViewerBundle() {
#ifdef DEEPSLAM_VIEWER_JS
  return {deepslam_viewer_begin,
          static_cast<std::size_t>(deepslam_viewer_end - deepslam_viewer_begin)};
#else
  return {};
#endif
}

}  // namespace deepslam::report
