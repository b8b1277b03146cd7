#include "deepslam/dataset/kept_frames.h"

#include <cstddef>
#include <mutex>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "deepslam/dataset/packed_depth.h"
#include "deepslam/frames/raw_depth.h"

namespace deepslam::dataset {
namespace {

// A depth image as it is, or packed.
class KeptDepth {
 public:
  explicit KeptDepth(DepthImage depth_m) : kept_(std::move(depth_m)) {}

  [[nodiscard]] KeptDepth Packed(const MetresOfRaw& metres) const {
    return KeptDepth(PackedDepth(std::get<DepthImage>(kept_), metres));
  }
  [[nodiscard]] DepthImage Pixels() const {
    if (const auto* packed = std::get_if<PackedDepth>(&kept_)) return packed->Unpacked();
    return std::get<DepthImage>(kept_);
  }
  [[nodiscard]] std::size_t num_bytes() const {
    if (const auto* packed = std::get_if<PackedDepth>(&kept_)) return packed->num_bytes();
    return sizeof(float) * std::get<DepthImage>(kept_).size();
  }

 private:
  explicit KeptDepth(PackedDepth packed) : kept_(std::move(packed)) {}
  std::variant<DepthImage, PackedDepth> kept_;
};

std::size_t NumBytes(const KeptDepth& depth) { return depth.num_bytes(); }
std::size_t NumBytes(const ColourImage& colour) { return sizeof(Rgb8) * colour.size(); }

// Images of one kind by frame, in the form in which they are kept.
template <typename Kept>
class KeptImages {
 public:
  explicit KeptImages(int num_frames) : entries_(static_cast<std::size_t>(num_frames)) {}

  // Null when it is not kept.
  [[nodiscard]] std::shared_ptr<const Kept> Find(FrameIdx frame) const { return At(frame).image; }
  // Whether an image that was read is to be kept: not the first time.
  [[nodiscard]] bool Offer(FrameIdx frame) {
    return std::exchange(At(frame).asked, true) && IsWanted(frame);
  }
  [[nodiscard]] bool IsWanted(FrameIdx frame) const { return !is_full_ && !At(frame).image; }
  // `free_bytes` shrinks; nothing more is wanted when they are too few.
  void Keep(FrameIdx frame, Kept image, std::size_t& free_bytes) {
    if (!IsWanted(frame)) return;
    is_full_ = NumBytes(image) > free_bytes;
    if (is_full_) return;
    free_bytes -= NumBytes(image);
    At(frame).image = std::make_shared<const Kept>(std::move(image));
  }
  // Each becomes what `smaller` makes of it, where that takes less.
  template <typename Smaller>
  void Shrink(const Smaller& smaller, std::size_t& free_bytes) {
    for (Entry& entry : entries_) {
      if (!entry.image) continue;
      auto less = std::make_shared<const Kept>(smaller(*entry.image));
      if (NumBytes(*less) >= NumBytes(*entry.image)) continue;
      free_bytes += NumBytes(*entry.image) - NumBytes(*less);
      entry.image = std::move(less);
    }
  }

 private:
  struct Entry {
    bool asked = false;
    std::shared_ptr<const Kept> image;
  };

  [[nodiscard]] Entry& At(FrameIdx frame) {
    return entries_[static_cast<std::size_t>(frame.value)];
  }
  [[nodiscard]] const Entry& At(FrameIdx frame) const {
    return entries_[static_cast<std::size_t>(frame.value)];
  }

  std::vector<Entry> entries_;
  bool is_full_ = false;
};

class KeptFrameSource final : public FrameSource {
 public:
  KeptFrameSource(std::unique_ptr<FrameSource> frames,
                  double depth_units_per_m,
                  std::size_t max_bytes)
      : frames_(std::move(frames)),
        metres_(depth_units_per_m),
        free_bytes_(max_bytes),
        depth_(frames_->num_frames()),
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
    if (const auto kept = Locked([&] { return depth_.Find(frame); }))
      return Frame{frame, time_s(frame), ColourImage(), kept->Pixels()};
    Result<Frame> read = frames_->ReadDepth(frame);
    if (read.ok() && Locked([&] { return depth_.Offer(frame); })) KeepDepth(frame, read->depth_m);
    return read;
  }

  [[nodiscard]] Result<StoredDepth> ReadStoredDepth(FrameIdx frame) const override {
    if (const auto kept = Locked([&] { return depth_.Find(frame); }))
      return StoredDepth(kept->Pixels());
    Result<StoredDepth> read = frames_->ReadStoredDepth(frame);
    if (!read.ok() || !Locked([&] { return depth_.Offer(frame); })) return read;
    DepthImage depth_m = (*std::move(read)).TakeMetres();
    KeepDepth(frame, depth_m);
    return StoredDepth(std::move(depth_m));
  }

  [[nodiscard]] Result<Frame> ReadColour(FrameIdx frame) const override {
    if (const auto kept = Locked([&] { return colour_.Find(frame); }))
      return Frame{frame, time_s(frame), *kept, DepthImage()};
    Result<Frame> read = frames_->ReadColour(frame);
    if (read.ok() && Locked([&] { return colour_.Offer(frame); })) KeepColour(frame, read->colour);
    return read;
  }

  void GiveBack(Frame frame) const override {
    if (!frame.depth_m.empty() && Locked([&] { return depth_.IsWanted(frame.idx); }))
      KeepDepth(frame.idx, std::move(frame.depth_m));
    if (!frame.colour.empty() && Locked([&] { return colour_.IsWanted(frame.idx); }))
      KeepColour(frame.idx, std::move(frame.colour));
  }

  // Not made of a kept colour: what a decoder makes of the file may be rounded otherwise.
  [[nodiscard]] Result<IntensityImage> ReadIntensity(FrameIdx frame, int factor) const override {
    return frames_->ReadIntensity(frame, factor);
  }

 private:
  template <typename Look>
  std::invoke_result_t<const Look&> Locked(const Look& look) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return look();
  }

  void KeepDepth(FrameIdx frame, DepthImage depth_m) const {
    KeptDepth kept(std::move(depth_m));
    const bool kept_as_it_is = Locked([&] {
      MakeRoomFor(NumBytes(kept));
      if (!packs_) depth_.Keep(frame, std::move(kept), free_bytes_);
      return !packs_;
    });
    if (kept_as_it_is) return;
    KeptDepth packed = kept.Packed(metres_);
    Locked([&] { depth_.Keep(frame, std::move(packed), free_bytes_); });
  }
  // Depth is kept as it is as long as all finds room, and packed from then on.
  void MakeRoomFor(std::size_t num_bytes) const {
    if (packs_ || num_bytes <= free_bytes_) return;
    packs_ = true;
    depth_.Shrink([&](const KeptDepth& depth) { return depth.Packed(metres_); }, free_bytes_);
  }
  void KeepColour(FrameIdx frame, ColourImage colour) const {
    Locked([&] {
      MakeRoomFor(NumBytes(colour));
      colour_.Keep(frame, std::move(colour), free_bytes_);
    });
  }

  std::unique_ptr<FrameSource> frames_;
  MetresOfRaw metres_;
  mutable std::mutex mutex_;
  mutable std::size_t free_bytes_;
  mutable bool packs_ = false;  // depth
  mutable KeptImages<KeptDepth> depth_;
  mutable KeptImages<ColourImage> colour_;
};

}  // namespace

std::unique_ptr<FrameSource> KeepFrames(std::unique_ptr<FrameSource> frames,
                                        double depth_units_per_m,
                                        std::size_t max_bytes) {
  return std::make_unique<KeptFrameSource>(std::move(frames), depth_units_per_m, max_bytes);
}

}  // namespace deepslam::dataset
