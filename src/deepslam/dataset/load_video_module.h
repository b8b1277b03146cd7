// The module that decodes videos (deepslam/video), found where the loader looks for the program's
// own libraries: its run path, LD_LIBRARY_PATH, the system's folders.
#pragma once

#include <string>

#include "deepslam/core/result.h"

namespace deepslam::video {
struct VideoModule;
}

namespace deepslam::dataset {

// It stays loaded. The error says what was looked for and why it could not be loaded.
[[nodiscard]] Result<const video::VideoModule*> LoadVideoModule(const std::string& file);

}  // namespace deepslam::dataset
