// Captures that name their files as 7-Scenes does: frame-000012.color.png, frame-000012.depth.png,
// frame-000012.pose.txt, in one folder. 7-Scenes, 3DMatch, BundleFusion, 3RScan.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "deepslam/dataset/image_pair.h"
#include "deepslam/layouts/layout.h"

namespace deepslam::layouts {

[[nodiscard]] bool HasFrameFiles(const std::filesystem::path& folder);
// The frames with a colour image, by number, times at 30 Hz; depth by the name that lies there,
// else PNG.
[[nodiscard]] std::vector<dataset::ImagePair> FrameFilePairs(const std::filesystem::path& folder);
// The names of their poses' files.
[[nodiscard]] std::vector<std::string> FramePoseNames(const std::vector<dataset::ImagePair>& pairs);
// Of layouts that have such files: what is missing names the sequence where one lies below.
[[nodiscard]] LayoutMatch MatchFrameFiles(const std::filesystem::path& folder);
// Refuses a folder without them.
[[nodiscard]] Status CheckFrameFiles(const std::filesystem::path& folder,
                                     const std::vector<dataset::ImagePair>& pairs);

}  // namespace deepslam::layouts
