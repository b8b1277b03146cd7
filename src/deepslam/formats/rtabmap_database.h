// RTAB-Map's databases (SQLite): nodes with their images, poses and calibrations. Everything in
// them is taken for whatever a stranger wrote: sizes are checked before anything is read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/lens_distortion.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::formats {

// A node's calibration, as its bytes say: the camera of its images, and where it sits on the base
// whose pose the node has.
struct NodeCamera {
  PinholeCamera camera;  // width 0: not stated
  std::optional<LensDistortion> lens;
  Pose3 base_from_camera;
};

// Of the serialised form (header of eleven numbers) and the older one (18 floats). kInvalidInput
// for other forms and for several cameras.
[[nodiscard]] Result<NodeCamera> ParseNodeCamera(std::string_view bytes);

struct Node {
  std::int64_t id = 0;
  double time_s = 0;
  std::optional<Pose3> world_from_base;  // by odometry
};

struct NodeImages {
  std::string colour;
  std::string depth;
  std::string calibration;
};

class RtabMapDatabase {
 public:
  // kInvalidInput for what is no database of RTAB-Map.
  static Result<std::unique_ptr<RtabMapDatabase>> Open(const std::filesystem::path& file);
  ~RtabMapDatabase();
  RtabMapDatabase(const RtabMapDatabase&) = delete;
  RtabMapDatabase& operator=(const RtabMapDatabase&) = delete;

  // Those that have a colour and a depth image, by number.
  [[nodiscard]] Result<std::vector<Node>> Nodes() const;
  // Thread-safe.
  [[nodiscard]] Result<NodeImages> Images(std::int64_t id) const;

 private:
  struct Impl;
  explicit RtabMapDatabase(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace deepslam::formats
