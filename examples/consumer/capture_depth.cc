// Prints layout, size and frames of a capture, and how much depth each of its first frames has.
#include <algorithm>
#include <cstdio>

#include "deepslam/layouts/open_capture.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: capture_depth CAPTURE\n");
    return 2;
  }
  const deepslam::Result<deepslam::dataset::Capture> capture =
      deepslam::layouts::OpenCapture(argv[1]);
  if (!capture.ok()) {
    std::fprintf(stderr, "%s\n", capture.error().message.c_str());
    return 3;
  }
  const deepslam::FrameSource& frames = *capture->frames;
  std::printf("%s: %d frames of %d x %d\n",
              capture->format.c_str(),
              frames.num_frames(),
              frames.camera().width,
              frames.camera().height);
  for (int i = 0; i < std::min(frames.num_frames(), 5); ++i) {
    const deepslam::Result<deepslam::Frame> frame = frames.ReadDepth(deepslam::FrameIdx{i});
    if (!frame.ok()) continue;  // others may be fine
    const deepslam::DepthImage& depth_m = frame->depth_m;
    int valid = 0;
    double sum_m = 0;
    for (int v = 0; v < depth_m.height(); ++v) {
      for (int u = 0; u < depth_m.width(); ++u) {
        if (depth_m(u, v) <= 0) continue;  // 0: no depth
        ++valid;
        sum_m += depth_m(u, v);
      }
    }
    std::printf("frame %d: %.1f %% valid, mean %.3f m\n",
                i,
                100.0 * valid / (depth_m.width() * depth_m.height()),
                valid > 0 ? sum_m / valid : 0.0);
  }
  return 0;
}
