#include "deepslam/dataset/kept_frames.h"

#include <cstdint>
#include <mutex>
#include <utility>
#include <vector>

namespace deepslam::dataset {
namespace {

// Images of one kind, by frame.
template <typename T>
class KeptImages {
 public:
  explicit KeptImages(int num_frames) : entries_(static_cast<std::size_t>(num_frames)) {}

  // Null when it is not kept.
  [[nodiscard]] std::shared_ptr<const Image<T>> Find(FrameIdx frame) const {
    return entries_[static_cast<std::size_t>(frame.value)].image;
  }
  // An image that was read; `free_bytes` shrinks when it is kept.
  void Offer(FrameIdx frame, const Image<T>& image, std::size_t& free_bytes) {
    Entry& entry = entries_[static_cast<std::size_t>(frame.value)];
    if (entry.asked && IsWanted(entry, image, free_bytes)) Keep(image, entry, free_bytes);
    entry.asked = true;
  }
  // One that nobody else needs.
  void TakeBack(FrameIdx frame, Image<T> image, std::size_t& free_bytes) {
    Entry& entry = entries_[static_cast<std::size_t>(frame.value)];
    if (IsWanted(entry, image, free_bytes)) Keep(std::move(image), entry, free_bytes);
  }

 private:
  struct Entry {
    bool asked = false;
    std::shared_ptr<const Image<T>> image;
  };

  static std::size_t NumBytes(const Image<T>& image) { return sizeof(T) * image.size(); }
  static bool IsWanted(const Entry& entry, const Image<T>& image, std::size_t free_bytes) {
    return !entry.image && NumBytes(image) <= free_bytes;
  }
  static void Keep(Image<T> image, Entry& entry, std::size_t& free_bytes) {
    free_bytes -= NumBytes(image);
    entry.image = std::make_shared<const Image<T>>(std::move(image));
  }

  std::vector<Entry> entries_;
};

class KeptFrameSource final : public FrameSource {
 public:
  KeptFrameSource(std::unique_ptr<FrameSource> frames, std::size_t max_bytes)
      : frames_(std::move(frames)),
        free_bytes_(max_bytes),
        depth_m_(frames_->num_frames()),
        colour_(frames_->num_frames()) {}

  [[nodiscard]] int num_frames() const override { return frames_->num_frames(); }
  [[nodiscard]] const PinholeCamera& camera() const override { return frames_->camera(); }
  [[nodiscard]] double time_s(FrameIdx frame) const override { return frames_->time_s(frame); }
  [[nodiscard]] std::optional<Pose3> capture_world_from_camera(FrameIdx frame) const override {
    return frames_->capture_world_from_camera(frame);
  }

  [[nodiscard]] Result<Frame> Read(FrameIdx frame) const override {
    Result<Frame> depth = ReadDepth(frame);
    if (!depth.ok()) return depth;
    Result<Frame> colour = ReadColour(frame);
    if (!colour.ok()) return colour;
    depth->colour = std::move(colour->colour);
    return depth;
  }

  [[nodiscard]] Result<Frame> ReadDepth(FrameIdx frame) const override {
    if (const auto kept = Find(depth_m_, frame))
      return Frame{frame, time_s(frame), ColourImage(), *kept};
    Result<Frame> read = frames_->ReadDepth(frame);
    if (read.ok()) Offer(depth_m_, frame, read->depth_m);
    return read;
  }

  [[nodiscard]] Result<Frame> ReadColour(FrameIdx frame) const override {
    if (const auto kept = Find(colour_, frame))
      return Frame{frame, time_s(frame), *kept, DepthImage()};
    Result<Frame> read = frames_->ReadColour(frame);
    if (read.ok()) Offer(colour_, frame, read->colour);
    return read;
  }

  void GiveBack(Frame frame) const override {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!frame.depth_m.empty()) depth_m_.TakeBack(frame.idx, std::move(frame.depth_m), free_bytes_);
    if (!frame.colour.empty()) colour_.TakeBack(frame.idx, std::move(frame.colour), free_bytes_);
  }

  // Not made of a kept colour: what a decoder makes of the file may be rounded otherwise.
  [[nodiscard]] Result<BrightnessImage> ReadBrightness(FrameIdx frame, int factor) const override {
    return frames_->ReadBrightness(frame, factor);
  }

 private:
  template <typename T>
  [[nodiscard]] std::shared_ptr<const Image<T>> Find(const KeptImages<T>& images,
                                                     FrameIdx frame) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return images.Find(frame);
  }
  template <typename T>
  void Offer(KeptImages<T>& images, FrameIdx frame, const Image<T>& image) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    images.Offer(frame, image, free_bytes_);
  }

  std::unique_ptr<FrameSource> frames_;
  mutable std::mutex mutex_;
  mutable std::size_t free_bytes_;
  mutable KeptImages<float> depth_m_;
  mutable KeptImages<Rgb8> colour_;
};

}  // namespace

std::unique_ptr<FrameSource> KeepFrames(std::unique_ptr<FrameSource> frames,
                                        std::size_t max_bytes) {
  return std::make_unique<KeptFrameSource>(std::move(frames), max_bytes);
}

}  // namespace deepslam::dataset
