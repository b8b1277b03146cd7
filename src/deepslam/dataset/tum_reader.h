// A TUM capture whose lists are read: frames on demand.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "deepslam/dataset/capture_settings.h"
#include "deepslam/dataset/tum_lists.h"
#include "deepslam/scene/frame_source.h"

namespace deepslam::dataset {

// Depth beyond this is invalid: no sensor this program is made for measures it.
inline constexpr double kMaxDepthM = 20.0;

// `world_from_camera` has one entry per pair. A frame's time is that of its depth image, since
// depth is what is tracked. Depth 0, 65535 (saturated) and beyond kMaxDepthM is invalid.
std::unique_ptr<FrameSource> MakeTumFrameSource(
    const std::filesystem::path& folder,
    const CaptureSettings& settings,
    std::vector<ImagePair> pairs,
    std::vector<std::optional<Pose3>> world_from_camera);

}  // namespace deepslam::dataset
