// Poses as layouts write them: a matrix per file, a pose per line.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::formats {

// World from camera, of each frame; nothing where it was lost.
using FramePoses = std::vector<std::optional<Pose3>>;

// The same camera with axes x right, y down, z forward, of one with OpenGL's and ARKit's: x right,
// y up, z back.
[[nodiscard]] Pose3 OfOpenGlCamera(const Pose3& world_from_open_gl);

// What a line of poses holds.
enum class PoseColumns {
  kMatrix,       // 16 numbers, row by row (or 12, without the last row)
  kXyzQuatXyzw,  // x y z qx qy qz qw
  kXyzQuatWxyz,  // x y z qw qx qy qz
};

// One pose a line, in order. Poses that are none (not finite, no rotation) are nothing and counted
// in a warning; a last line that the file ends within is left out.
[[nodiscard]] Result<FramePoses> ParsePoseLines(const std::string& text,
                                                const std::filesystem::path& file,
                                                PoseColumns columns,
                                                std::vector<std::string>& warnings);

// Files of 4 x 4 matrices, one per frame; those that do not exist are nothing. `text` is all of
// them with their names, for the capture's hash.
struct MatrixFiles {
  FramePoses poses;
  std::string text;
};
[[nodiscard]] Result<MatrixFiles> ReadMatrixFiles(const std::filesystem::path& folder,
                                                  const std::vector<std::string>& names,
                                                  std::vector<std::string>& warnings);

}  // namespace deepslam::formats
