// What the layouts that are lists of files share: TUM RGB-D, ETH3D-SLAM, ICL-NUIM.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/formats/tum_lists.h"

namespace deepslam::layouts {

inline constexpr std::string_view kPosesName = "groundtruth.txt";

// Which of the lists are there.
[[nodiscard]] std::vector<std::string> ListsOf(const std::filesystem::path& folder);

// The frames of a folder: associations.txt or associated.txt, else rgb.txt and depth.txt paired by
// time (0.02 s). Refused where the times of rgb.txt and depth.txt fall back unlike each other.
[[nodiscard]] Result<std::vector<dataset::ImagePair>> ReadPairs(const std::filesystem::path& folder,
                                                                std::vector<std::string>& warnings);

// Of each frame, the pose at the time of its depth image: interpolated within gaps of 0.1 s, else
// the nearest within 0.02 s. Poses are those of the frame's own segment of the clock; where the
// times of poses and frames fall back unlike each other, frames have none whose time stands for
// several moments.
[[nodiscard]] std::vector<std::optional<Pose3>> PosesAt(
    const std::vector<formats::TimedPose>& poses, const std::vector<dataset::ImagePair>& pairs);

}  // namespace deepslam::layouts
