// capture.yaml: what the images alone do not say. All fields may be left out where the layout knows
// them itself; what stands here wins.
//   format: tum                                        # one of kFormats; else found by layout
//   camera: {width: 640, height: 480, fx: 525, fy: 525, cx: 319.5, cy: 239.5}   # px, colour camera
//   depth_units_per_m: 5000                            # value of one metre in the depth images
//   depth_camera: {width: ..., fx: ...}                # px; where depth is not registered to
//   colour colour_from_depth: {translation_m: [x, y, z], rotation_xyzw: [x, y, z, w]}
//   min_confidence: 1                                  # least confidence of depth that is kept
//   max_frames: 120000                                 # of more, every second (third ...) is taken
//   assumed: [camera, depth_units_per_m]               # what nobody has confirmed: doubted
// Both cameras may have a lens: {width: ..., distortion: {model: radial-tangential, coefficients:
// [k1, k2, p1, p2, k3]}}; models: radial-tangential, rational, fisheye
// (geometry/lens_distortion.h). With `camera` and without `depth_camera`, depth is taken for
// registered to colour.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/lens_distortion.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::dataset {

// Names of the layouts that are read (layout.h).
inline constexpr std::array<std::string_view, 22> kFormats = {
    "tum",         "eth3d",   "icl-nuim",   "7-scenes",       "3dmatch",   "bundlefusion",
    "3rscan",      "open3d",  "scannet",    "scannet-export", "scannetpp", "stray",
    "arkitscenes", "polycam", "record3d",   "nerfstudio",     "replica",   "habitat",
    "sun3d",       "rtabmap", "rtabmap-db", "folders"};

// Frames that are taken where nothing is stated: what is known of each of them takes memory, and
// two hours at 30 frames/s are as well tracked at 15.
inline constexpr int kMaxFrames = 120'000;

struct CaptureSettings {
  std::string format = "tum";          // empty: not stated
  PinholeCamera camera;                // of the colour images; width 0: not stated
  double depth_units_per_m = 0;        // value of one metre in the depth images; 0: not stated
  std::optional<LensDistortion> lens;  // of `camera`
  std::optional<PinholeCamera> depth_camera;
  std::optional<LensDistortion> depth_lens;
  std::optional<Pose3> colour_from_depth;
  std::optional<int> min_confidence;
  std::optional<int> max_frames;
  std::vector<std::string> assumed;  // fields
  std::vector<std::string> warnings;

  [[nodiscard]] bool has_camera() const { return camera.width > 0; }
};

// Reads the text of a capture.yaml; `file` names it in messages. Fields that are not stated stay
// empty.
Result<CaptureSettings> ParseCaptureSettings(const std::string& text,
                                             const std::filesystem::path& file);

// Refuses settings without camera or depth units, showing a complete file.
Status RequireComplete(const CaptureSettings& settings, const std::filesystem::path& file);

// Settings of a capture without capture.yaml, from the folder's name (TUM freiburg1, 2, 3); an
// error that shows how to write a capture.yaml when the name tells nothing.
Result<CaptureSettings> SettingsFromName(const std::filesystem::path& folder);

// The same settings as YAML text.
std::string FormatCaptureSettings(const CaptureSettings& settings);

// Refuses cameras no lens has: sizes outside 1 .. 16384 px, fields of view outside 1 .. 170
// degrees, a principal point outside the image. `file` names the source in messages, `name` the
// field.
Status CheckCamera(const PinholeCamera& camera,
                   const std::filesystem::path& file,
                   std::string_view name = "camera");

}  // namespace deepslam::dataset
