#include "deepslam/dataset/video_file.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <utility>

#include <fmt/format.h>

#include "deepslam/dataset/load_video_module.h"
#include "deepslam/video/video_module.h"

namespace deepslam::dataset {
namespace {

constexpr int kMaxVideoSidePx = 16384;  // files of more are refused before memory is taken
// A hundred decoded frames of 640 x 480, in case they are asked for again.
constexpr std::size_t kMaxKeptBytes = std::size_t{96} << 20;

struct CloseDecoder {
  const video::VideoModule* module = nullptr;
  void operator()(video::Decoder* decoder) const { module->close(decoder); }
};
using DecoderPtr = std::unique_ptr<video::Decoder, CloseDecoder>;

// Loaded once; asked for by several threads, of which one loads.
Result<const video::VideoModule*> Module() {
  static const Result<const video::VideoModule*> kModule = LoadVideoModule(video::kModuleFile);
  return kModule;
}

}  // namespace

struct VideoFile::Impl {
  std::filesystem::path file;
  const video::VideoModule* module = nullptr;
  int width = 0;
  int height = 0;
  int num_frames = 0;
  std::size_t max_kept = 0;

  std::mutex mutex;
  DecoderPtr decoder;
  int next = 0;  // index of the frame that the decoder gives next
  std::map<int, ColourImage> kept;

  bool Start() {
    decoder = DecoderPtr(module->open(file.c_str()), CloseDecoder{module});
    next = 0;
    return decoder != nullptr;
  }

  // The frame `next`, kept when `wanted`; false at the end of what can be decoded.
  bool Step(bool wanted) {
    if (wanted) {
      ColourImage frame(width, height);
      if (!module->next(decoder.get(), reinterpret_cast<unsigned char*>(frame.data())))
        return false;
      kept[next] = std::move(frame);
      while (kept.size() > max_kept) kept.erase(kept.begin());
    } else if (!module->next(decoder.get(), nullptr)) {
      return false;
    }
    ++next;
    return true;
  }
};

VideoFile::VideoFile(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
VideoFile::~VideoFile() = default;

Result<std::unique_ptr<VideoFile>> VideoFile::Open(const std::filesystem::path& file) {
  const Result<const video::VideoModule*> module = Module();
  if (!module) return Error{module.error().code, file.string() + ": " + module.error().message};
  auto impl = std::make_unique<Impl>();
  impl->file = file;
  impl->module = *module;
  if (!impl->Start())
    return InvalidInput(fmt::format("{}: not a video that can be decoded here", file.string()));
  impl->width = impl->module->width(impl->decoder.get());
  impl->height = impl->module->height(impl->decoder.get());
  impl->num_frames = impl->module->num_frames(impl->decoder.get());
  if (impl->width < 1 || impl->height < 1 || impl->width > kMaxVideoSidePx ||
      impl->height > kMaxVideoSidePx) {
    return InvalidInput(
        fmt::format("{}: has frames of {} x {} px", file.string(), impl->width, impl->height));
  }
  const std::size_t frame_bytes =
      3 * static_cast<std::size_t>(impl->width) * static_cast<std::size_t>(impl->height);
  impl->max_kept = std::max<std::size_t>(4, kMaxKeptBytes / frame_bytes);
  return std::unique_ptr<VideoFile>(new VideoFile(std::move(impl)));
}

const std::filesystem::path& VideoFile::file() const { return impl_->file; }
int VideoFile::num_frames() const { return impl_->num_frames; }
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
