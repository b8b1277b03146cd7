// The end of every layout whose images are single files: hash, frames, what is left of the cameras.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/dataset/file_frames.h"
#include "deepslam/formats/pose_texts.h"
#include "deepslam/layouts/layout.h"
#include "deepslam/layouts/settle_images.h"

namespace deepslam::layouts {

struct FilesOfLayout {
  std::string_view tag;                   // the layout's name, in the hash
  std::vector<dataset::NamedText> texts;  // what else the capture hangs on; capture.yaml is added
  std::vector<dataset::ImagePair> pairs;
  formats::FramePoses poses;  // per pair; empty: none
  std::string poses_file;
  SettledImages settled;
  // Where frames have colour cameras of their own and depth none, depth has the same view.
  dataset::Optics optics;
  bool has_times = false;
};

// Refuses a capture of which most images are missing; a few are skipped with a warning.
[[nodiscard]] Result<OpenedLayout> OpenFiles(const LayoutSource& source,
                                             FilesOfLayout files,
                                             std::vector<std::string> warnings);

}  // namespace deepslam::layouts
