#include "deepslam/dataset/capture_frame_source.h"

#include <atomic>
#include <utility>
#include <vector>

#include "deepslam/dataset/depth_registration.h"
#include "deepslam/frames/intensity.h"
#include "deepslam/frames/raw_depth.h"

namespace deepslam::dataset {
namespace {

class CaptureFrameSource final : public FrameSource {
 public:
  CaptureFrameSource(std::shared_ptr<const StoredFrames> stored, std::shared_ptr<ReadFaults> faults)
      : stored_(std::move(stored)),
        faults_(std::move(faults)),
        camera_(FrameCamera(stored_->cameras())),
        reduction_(ColourReduction(stored_->cameras())),
        metres_(stored_->cameras().depth_units_per_m),
        colour_was_read_(stored_->frames().size()),
        depth_was_read_(stored_->frames().size()) {}

  [[nodiscard]] int num_frames() const override {
    return static_cast<int>(stored_->frames().size());
  }
  [[nodiscard]] const PinholeCamera& camera() const override { return camera_; }
  [[nodiscard]] double time_s(FrameIdx frame) const override { return At(frame).depth_time_s; }

  [[nodiscard]] Result<Frame> Read(FrameIdx frame) const override {
    Result<Frame> depth = ReadDepth(frame);
    if (!depth) return depth;
    Result<Frame> colour = ReadColour(frame);
    if (!colour) return colour;
    colour->depth_m = std::move(depth->depth_m);
    return colour;
  }

  [[nodiscard]] Result<Frame> ReadDepth(FrameIdx frame) const override {
    Result<StoredDepth> stored = ReadStoredDepth(frame);
    if (!stored) return stored.error();
    return Frame{frame, At(frame).depth_time_s, ColourImage(), (*std::move(stored)).TakeMetres()};
  }

  [[nodiscard]] Result<StoredDepth> ReadStoredDepth(FrameIdx frame) const override {
    Result<RawDepthImage> raw = Noted(stored_->ReadDepth(Index(frame)), depth_was_read_, frame);
    if (!raw) return raw.error();
    const CaptureCameras& cameras = stored_->cameras();
    if (cameras.registered() && reduction_ == 1) return StoredDepth(*std::move(raw), metres_);
    return StoredDepth(
        RegisterDepth(metres_.Of(*raw), cameras.depth, cameras.colour_from_depth, camera_));
  }

  [[nodiscard]] Result<Frame> ReadColour(FrameIdx frame) const override {
    const double time_s = At(frame).depth_time_s;
    Result<StoredColour> stored = Noted(stored_->ReadColour(Index(frame)), colour_was_read_, frame);
    if (!stored) return stored.error();
    Result<ColourImage> colour = DecodeStored(*std::move(stored), stored_->cameras().colour);
    if (!colour) return colour.error();
    if (reduction_ > 1) *colour = ReduceColour(*colour, reduction_);
    return Frame{frame, time_s, *std::move(colour), DepthImage()};
  }

  [[nodiscard]] Result<IntensityImage> ReadIntensity(FrameIdx frame, int factor) const override {
    const Result<StoredColour> stored =
        Noted(stored_->ReadColour(Index(frame)), colour_was_read_, frame);
    if (!stored) return stored.error();
    const int of_stored = reduction_ * factor;
    if (stored->codec == ImageCodec::kOther) return IntensityOf(stored->pixels, of_stored);
    const PinholeCamera& camera = stored_->cameras().colour;
    return DecodeIntensity(stored->bytes, stored->name, camera.width, camera.height, of_stored);
  }

  [[nodiscard]] std::optional<Pose3> capture_world_from_camera(FrameIdx frame) const override {
    return At(frame).world_from_colour;
  }

 private:
  using WasRead = std::vector<std::atomic<bool>>;

  [[nodiscard]] static std::size_t Index(FrameIdx frame) {
    return static_cast<std::size_t>(frame.value);
  }
  [[nodiscard]] const StoredFrame& At(FrameIdx frame) const {
    DEEPSLAM_CHECK(frame.valid() && frame.value < num_frames(), "frame outside the capture");
    return stored_->frames()[Index(frame)];
  }

  // What was read once and cannot be any more is no bad frame: the capture changed or went away.
  template <typename T>
  [[nodiscard]] Result<T> Noted(Result<T> read, WasRead& was_read, FrameIdx frame) const {
    std::atomic<bool>& before = was_read[Index(frame)];
    if (read) {
      before.store(true, std::memory_order_relaxed);
      return read;
    }
    Error error = read.error();
    if (before.load(std::memory_order_relaxed) && error.code == ErrorCode::kInvalidInput)
      error =
          Failed(error.message + "; it was read before: leave the capture as it is, and run again");
    if (faults_) faults_->Note(error);
    return error;
  }

  std::shared_ptr<const StoredFrames> stored_;
  std::shared_ptr<ReadFaults> faults_;
  PinholeCamera camera_;
  int reduction_;
  MetresOfRaw metres_;
  mutable WasRead colour_was_read_;
  mutable WasRead depth_was_read_;
};

}  // namespace

std::unique_ptr<FrameSource> MakeCaptureFrameSource(std::shared_ptr<const StoredFrames> stored,
                                                    std::shared_ptr<ReadFaults> faults) {
  return std::make_unique<CaptureFrameSource>(std::move(stored), std::move(faults));
}

}  // namespace deepslam::dataset
