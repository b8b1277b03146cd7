#include "deepslam/dataset/video_file.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <utility>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>

namespace deepslam::dataset {
namespace {

constexpr int kMaxSidePx = 16384;
constexpr std::size_t kMaxKeptBytes = std::size_t{96} << 20;

ColourImage ToImage(const cv::Mat& bgr) {
  ColourImage image(bgr.cols, bgr.rows);
  for (int v = 0; v < bgr.rows; ++v) {
    const unsigned char* from = bgr.ptr<unsigned char>(v);
    Rgb8* to = image.row(v);
    for (int u = 0; u < bgr.cols; ++u, from += 3) to[u] = {from[2], from[1], from[0]};
  }
  return image;
}

}  // namespace

struct VideoFile::Impl {
  std::filesystem::path file;
  int width = 0;
  int height = 0;
  std::size_t max_kept = 0;

  std::mutex mutex;
  cv::VideoCapture capture;
  int next = 0;  // index of the frame that the decoder gives next
  std::map<int, ColourImage> kept;

  bool Start() {
    try {
      if (!capture.open(file.string(), cv::CAP_FFMPEG)) return false;
      capture.set(cv::CAP_PROP_ORIENTATION_AUTO, 0);
    } catch (const cv::Exception&) {
      return false;
    }
    next = 0;
    return true;
  }

  // The frame `next`, kept when `wanted`; false at the end of what can be decoded.
  bool Step(bool wanted) {
    try {
      if (!capture.grab()) return false;
      if (wanted) {
        cv::Mat bgr;
        if (!capture.retrieve(bgr) || bgr.type() != CV_8UC3 || bgr.cols != width ||
            bgr.rows != height) {
          return false;
        }
        kept[next] = ToImage(bgr);
        while (kept.size() > max_kept) kept.erase(kept.begin());
      }
    } catch (const cv::Exception&) {
      return false;
    }
    ++next;
    return true;
  }
};

VideoFile::VideoFile(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
VideoFile::~VideoFile() = default;

Result<std::unique_ptr<VideoFile>> VideoFile::Open(const std::filesystem::path& file) {
  auto impl = std::make_unique<Impl>();
  impl->file = file;
  if (!impl->Start())
    return InvalidInput(fmt::format("{}: not a video that can be decoded here", file.string()));
  impl->width = static_cast<int>(impl->capture.get(cv::CAP_PROP_FRAME_WIDTH));
  impl->height = static_cast<int>(impl->capture.get(cv::CAP_PROP_FRAME_HEIGHT));
  if (impl->width < 1 || impl->height < 1 || impl->width > kMaxSidePx ||
      impl->height > kMaxSidePx) {
    return InvalidInput(
        fmt::format("{}: has frames of {} x {} px", file.string(), impl->width, impl->height));
  }
  const std::size_t frame_bytes =
      3 * static_cast<std::size_t>(impl->width) * static_cast<std::size_t>(impl->height);
  impl->max_kept = std::max<std::size_t>(4, kMaxKeptBytes / frame_bytes);
  return std::unique_ptr<VideoFile>(new VideoFile(std::move(impl)));
}

int VideoFile::width() const { return impl_->width; }
int VideoFile::height() const { return impl_->height; }

Result<ColourImage> VideoFile::Read(int index) {
  Impl& impl = *impl_;
  const std::lock_guard lock(impl.mutex);
  if (const auto found = impl.kept.find(index); found != impl.kept.end()) return found->second;
  if (index < impl.next) {
    impl.kept.clear();
    if (!impl.Start())
      return InvalidInput(fmt::format("{}: cannot be opened again", impl.file.string()));
  }
  while (impl.next <= index) {
    const bool wanted = index - impl.next < static_cast<int>(impl.max_kept);
    if (impl.Step(wanted)) continue;
    return InvalidInput(
        fmt::format("{}: frame {} cannot be decoded (the video ends, or is damaged, "
                    "after {} frames)",
                    impl.file.string(),
                    index,
                    impl.next));
  }
  return impl.kept.at(index);
}

}  // namespace deepslam::dataset
