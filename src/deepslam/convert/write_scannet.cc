#include <cmath>
#include <fstream>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "deepslam/convert/capture_writer.h"
#include "deepslam/formats/sens_file.h"

namespace deepslam::convert {
namespace {

namespace fs = std::filesystem;

std::array<float, 16> ToFloats(const Eigen::Matrix4d& matrix) {
  std::array<float, 16> floats{};
  for (int i = 0; i < 16; ++i)
    floats[static_cast<std::size_t>(i)] = static_cast<float>(matrix(i / 4, i % 4));
  return floats;
}

std::array<float, 16> Intrinsics(const PinholeCamera& camera) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix(0, 0) = camera.fx;
  matrix(1, 1) = camera.fy;
  matrix(0, 2) = camera.cx;
  matrix(1, 2) = camera.cy;
  return ToFloats(matrix);
}

std::array<float, 16> LostPose() {
  std::array<float, 16> lost{};
  lost.fill(-std::numeric_limits<float>::infinity());
  return lost;
}

class WriterOfScanNet final : public CaptureWriter {
 public:
  WriterOfScanNet(fs::path file, const WriteSettings& settings)
      : file_(std::move(file)),
        settings_(settings),
        out_(file_, std::ios::binary | std::ios::trunc) {}

  [[nodiscard]] Status Add(const WriteFrame& frame) override {
    const Result<std::string> colour = ColourBytes(frame.colour);
    if (!colour) return colour.error();
    const Result<std::string> depth = formats::PackDepthZlib(frame.depth);
    if (!depth) return depth.error();
    if (num_frames_ == 0) WriteHeader(frame.colour);
    formats::SensFrame head;
    head.world_from_depth =
        frame.world_from_colour
            ? ToFloats((*frame.world_from_colour * settings_.cameras.colour_from_depth).Matrix())
            : LostPose();
    head.colour_time_us = Microseconds(frame.colour_time_s);
    head.depth_time_us = Microseconds(frame.depth_time_s);
    head.colour_bytes = colour->size();
    head.depth_bytes = depth->size();
    out_ << formats::EncodeSensFrame(head) << *colour << *depth;
    ++num_frames_;
    return Check();
  }

  [[nodiscard]] Status Finish() override {
    // The format's count of inertial readings, of which none are written.
    constexpr std::uint64_t kNoMotions = 0;
    out_.write(reinterpret_cast<const char*>(&kNoMotions), sizeof(kNoMotions));
    out_.seekp(num_frames_at_);
    out_.write(reinterpret_cast<const char*>(&num_frames_), sizeof(num_frames_));
    out_.close();
    return Check();
  }

 private:
  static std::uint64_t Microseconds(double time_s) {
    return static_cast<std::uint64_t>(std::llround(std::max(0.0, time_s) * 1e6));
  }

  // One codec stands for all images; readers go by the images' own first bytes.
  void WriteHeader(const dataset::StoredColour& first) {
    const dataset::CaptureCameras& cameras = settings_.cameras;
    formats::SensHeader header;
    header.sensor_name = "deepslam convert";
    header.colour_intrinsics = Intrinsics(cameras.colour);
    header.colour_extrinsics = ToFloats(Eigen::Matrix4d::Identity());
    header.depth_intrinsics = Intrinsics(cameras.depth);
    header.depth_extrinsics = ToFloats(cameras.colour_from_depth.Matrix());
    header.colour_codec = first.codec == dataset::ImageCodec::kJpeg
                              ? formats::SensColourCodec::kJpeg
                              : formats::SensColourCodec::kPng;
    header.depth_codec = formats::SensDepthCodec::kZlib;
    header.colour_width = static_cast<std::uint32_t>(cameras.colour.width);
    header.colour_height = static_cast<std::uint32_t>(cameras.colour.height);
    header.depth_width = static_cast<std::uint32_t>(cameras.depth.width);
    header.depth_height = static_cast<std::uint32_t>(cameras.depth.height);
    header.depth_shift = static_cast<float>(cameras.depth_units_per_m);
    const std::string bytes = formats::EncodeSensHeader(header);
    num_frames_at_ = static_cast<std::streamoff>(bytes.size() - formats::kSensNumFramesFromEnd);
    out_ << bytes;
  }

  [[nodiscard]] Status Check() const {
    if (out_) return Ok();
    return Failed(fmt::format("{}: cannot be written; is the disk full or the folder read-only?",
                              file_.string()));
  }

  fs::path file_;
  WriteSettings settings_;
  std::ofstream out_;
  std::streamoff num_frames_at_ = 0;
  std::uint64_t num_frames_ = 0;
};

}  // namespace

Result<std::unique_ptr<CaptureWriter>> CreateScanNet(const fs::path& path,
                                                     const WriteSettings& settings) {
  return std::unique_ptr<CaptureWriter>(std::make_unique<WriterOfScanNet>(path, settings));
}

}  // namespace deepslam::convert
