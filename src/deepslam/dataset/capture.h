// A capture opened for reading, whatever its layout (layouts/open_capture.h opens it).
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "deepslam/dataset/read_faults.h"
#include "deepslam/dataset/stored_frames.h"
#include "deepslam/frames/frame_source.h"

namespace deepslam::dataset {

struct Capture {
  std::unique_ptr<FrameSource> frames;
  std::shared_ptr<const StoredFrames> stored;  // what the frames are made from
  std::shared_ptr<const ReadFaults> faults;    // of the machine, met while frames were read
  std::filesystem::path path;                  // as the user named it
  std::string name;                            // the folder's or file's own name, without its path
  std::string format;                          // the layout's name
  // SHA-256 over capture.yaml, calibration, poses and the ordered frames: file names relative to
  // the folder, times and file contents. Two captures with equal hash give equal frames, wherever
  // they lie.
  std::string content_hash;
  std::vector<std::string> warnings;  // what was repaired or left out, for the user
  std::vector<std::string> doubts;    // those of the warnings that doubts.h tells
  bool has_poses = false;             // at least one frame has a pose
  // Of poses that contradict the depth: what would fit. A result that is built on them is none.
  std::string poses_fault;
  bool has_times = true;  // false: the layout has none, frames are taken for 30 per second
};

}  // namespace deepslam::dataset
