#include "deepslam/video/video_module.h"

#include <memory>

#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>

namespace deepslam::video {

struct Decoder {
  cv::VideoCapture capture;
  cv::Mat bgr;
  int width = 0;   // px
  int height = 0;  // px
  int num_frames = 0;
};

namespace {

Decoder* Open(const char* file) {
  try {
    auto decoder = std::make_unique<Decoder>();
    if (!decoder->capture.open(file, cv::CAP_FFMPEG)) return nullptr;
    decoder->capture.set(cv::CAP_PROP_ORIENTATION_AUTO, 0);
    decoder->width = static_cast<int>(decoder->capture.get(cv::CAP_PROP_FRAME_WIDTH));
    decoder->height = static_cast<int>(decoder->capture.get(cv::CAP_PROP_FRAME_HEIGHT));
    const double num_frames = decoder->capture.get(cv::CAP_PROP_FRAME_COUNT);
    if (num_frames >= 1 && num_frames < 1e9) decoder->num_frames = static_cast<int>(num_frames);
    return decoder.release();
  } catch (const cv::Exception&) {
    return nullptr;
  }
}

void Close(Decoder* decoder) { delete decoder; }
int Width(const Decoder* decoder) { return decoder->width; }
int Height(const Decoder* decoder) { return decoder->height; }
int NumFrames(const Decoder* decoder) { return decoder->num_frames; }

void CopyAsRgb(const cv::Mat& bgr, unsigned char* to) {
  for (int v = 0; v < bgr.rows; ++v) {
    const unsigned char* from = bgr.ptr<unsigned char>(v);
    for (int u = 0; u < bgr.cols; ++u, from += 3, to += 3) {
      to[0] = from[2];
      to[1] = from[1];
      to[2] = from[0];
    }
  }
}

bool Next(Decoder* decoder, unsigned char* rgb) {
  try {
    if (!decoder->capture.grab()) return false;
    if (rgb == nullptr) return true;
    cv::Mat& bgr = decoder->bgr;
    if (!decoder->capture.retrieve(bgr) || bgr.type() != CV_8UC3 || bgr.cols != decoder->width ||
        bgr.rows != decoder->height) {
      return false;
    }
    CopyAsRgb(bgr, rgb);
    return true;
  } catch (const cv::Exception&) {
    return false;
  }
}

}  // namespace
}  // namespace deepslam::video

const deepslam::video::VideoModule* deepslam_video_module() {
  using namespace deepslam::video;
  static constexpr VideoModule kModule = {
      VideoModule::kVersion, Open, Close, Width, Height, NumFrames, Next};
  return &kModule;
}
