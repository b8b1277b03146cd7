// A colour camera out of a text file that holds its 3 x 3 matrix, as SUN3D and 3DMatch keep it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/dataset/image_pair.h"
#include "deepslam/geometry/camera.h"

namespace deepslam::layouts {

struct MatrixCamera {
  PinholeCamera camera;
  std::string text;  // of the file
};

// Its images' size is that of the first colour file. Errors name the file: unreadable, not nine
// numbers, a camera that cannot be.
[[nodiscard]] Result<MatrixCamera> ReadMatrixCamera(const std::filesystem::path& file,
                                                    const std::filesystem::path& folder,
                                                    const std::vector<dataset::ImagePair>& pairs);

}  // namespace deepslam::layouts
