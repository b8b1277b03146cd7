// Writes a capture in the TUM layout, frame by frame; OpenCapture reads it back.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/dataset/capture_settings.h"
#include "deepslam/frames/frame.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::convert {

class TumWriter {
 public:
  // Makes the folder with rgb/ and depth/. Refuses a folder that exists and is not empty, so that
  // no capture of the user's is mixed with this one.
  static Result<TumWriter> Create(const std::filesystem::path& folder,
                                  const dataset::CaptureSettings& settings);

  // rgb/<number>.jpg (quality 95) and depth/<number>.png (16 bit). Depth that does not fit 16 bits
  // becomes invalid.
  Status AddFrame(const Frame& frame, const std::optional<Pose3>& world_from_camera);

  // The lists, groundtruth.txt where poses were given, and capture.yaml. Call once, at the end.
  Status Finish();

  [[nodiscard]] int num_frames() const { return static_cast<int>(rows_.size()); }

 private:
  struct Row {
    double time_s = 0;
    std::optional<Pose3> world_from_camera;
  };
  TumWriter(std::filesystem::path folder, dataset::CaptureSettings settings);

  std::filesystem::path folder_;
  dataset::CaptureSettings settings_;
  std::vector<Row> rows_;
};

}  // namespace deepslam::convert
