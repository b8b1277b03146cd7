// A capture folder opened for reading: any known layout becomes a FrameSource.
//
// Layouts: TUM RGB-D. `associations.txt` or `associated.txt` (`time rgb/file time depth/file`), or
// `rgb.txt` and `depth.txt` associated by time; optional `groundtruth.txt` (`time tx ty tz qx qy qz
// qw`, world from colour camera); optional `capture.yaml`:
//   format: tum
//   camera: {width: 640, height: 480, fx: 525, fy: 525, cx: 319.5, cy: 239.5}   # px, colour camera
//   depth_units_per_m: 5000                                                     # value of one
//   metre in the PNGs
// Without it the intrinsics must be known from the folder's name (freiburg1 .. 3 of TUM RGB-D).
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/scene/frame_source.h"

namespace deepslam::dataset {

struct Capture {
  std::unique_ptr<FrameSource> frames;
  std::string name;  // the folder's own name, without its path
  // SHA-256 over capture.yaml, groundtruth.txt and the ordered frames: file names relative to the
  // folder, times and file contents. Two folders with equal hash give equal frames, wherever they
  // lie.
  std::string content_hash;
  std::vector<std::string> warnings;  // what was repaired or left out, for the user
  std::vector<std::string>
      colour_files;  // of each frame, relative to the folder: the names foreign annotations use
  bool has_poses = false;  // at least one frame has a pose
};

// Opens a capture. Frames are read later, one at a time; here every file is read once for the hash,
// and a few frames are decoded so that a capture of which nothing can be used is refused now.
// Errors name file, line, field and remedy.
Result<Capture> OpenCapture(const std::filesystem::path& folder);

}  // namespace deepslam::dataset
