// Lists of poses, a line each. The first byte is what the lines hold.
#include <cmath>
#include <optional>
#include <vector>

#include "deepslam/formats/pose_texts.h"

#include "fuzz/entry.h"

DEEPSLAM_FUZZ(pose_lines) {
  if (bytes.empty()) return false;
  const auto columns =
      static_cast<formats::PoseColumns>(static_cast<unsigned char>(bytes.front()) % 3);
  std::vector<std::string> warnings;
  const auto poses =
      formats::ParsePoseLines(std::string(bytes.substr(1)), kFile, columns, warnings);
  if (!poses.ok()) return Refused(poses.error());
  for (const std::optional<Pose3>& pose : *poses) {
    if (!pose) continue;
    DEEPSLAM_CHECK(pose->translation_m.allFinite(), "a position is finite");
    DEEPSLAM_CHECK(std::abs(pose->rotation.norm() - 1) < 1e-6, "a rotation is one");
  }
  return true;
}
