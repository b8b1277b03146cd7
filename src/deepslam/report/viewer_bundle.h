// The script of the 3D view, as it was bundled when the program was built.
#pragma once

#include <string_view>

namespace deepslam::report {

// One classic script without imports; empty when the program was built without three.js.
[[nodiscard]] std::string_view ViewerBundle();

}  // namespace deepslam::report
