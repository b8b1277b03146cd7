#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "deepslam/convert/capture_writer.h"
#include "deepslam/formats/pose_matrix.h"

namespace deepslam::convert {
namespace {

namespace fs = std::filesystem;

constexpr double kUsualUnitsPerM = 1000;  // millimetres, which Open3D takes without a configuration

class WriterOfOpen3d final : public CaptureWriter {
 public:
  WriterOfOpen3d(fs::path folder, const WriteSettings& settings)
      : folder_(std::move(folder)), settings_(settings) {}

  [[nodiscard]] Status Add(const WriteFrame& frame) override {
    const Result<std::string> bytes = ColourBytes(frame.colour);
    if (!bytes) return bytes.error();
    const std::string colour =
        Stem(frame.number, frame.colour_time_s) + std::string(ColourEnd(frame.colour));
    if (Status status = WriteWhole(folder_ / "color" / colour, *bytes); !status) return status;
    const std::string depth = Stem(frame.number, frame.depth_time_s) + ".png";
    if (Status status = dataset::WriteDepthFile(folder_ / "depth" / depth, frame.depth); !status)
      return status;
    if (frame.world_from_colour) {
      log_ += fmt::format("{0} {0} {1}\n{2}",
                          num_frames_,
                          num_frames_ + 1,
                          formats::FormatMatrix(*frame.world_from_colour));
    }
    ++num_frames_;
    return Ok();
  }

  [[nodiscard]] Status Finish() override {
    const dataset::CaptureCameras& cameras = settings_.cameras;
    const PinholeCamera& c = cameras.colour;
    const std::string intrinsics = fmt::format(
        "{{\n  \"width\": {},\n  \"height\": {},\n  \"intrinsic_matrix\": [{}, 0, 0, 0, {}, 0, {}, "
        "{}, 1]\n}}\n",
        c.width,
        c.height,
        c.fx,
        c.fy,
        c.cx,
        c.cy);
    if (Status status = WriteWhole(folder_ / "camera_intrinsic.json", intrinsics); !status)
      return status;
    if (cameras.depth_units_per_m != kUsualUnitsPerM) {
      const std::string config = fmt::format(
          "{{\n  \"path_intrinsic\": \"camera_intrinsic.json\",\n  \"depth_scale\": {}\n}}\n",
          cameras.depth_units_per_m);
      if (Status status = WriteWhole(folder_ / "config.json", config); !status) return status;
    }
    return log_.empty() ? Ok() : WriteWhole(folder_ / "trajectory.log", log_);
  }

 private:
  // With times, as in the Redwood data sets: number and microseconds.
  [[nodiscard]] std::string Stem(std::int64_t number, double time_s) const {
    if (!settings_.has_times) return fmt::format("{:06d}", number);
    return fmt::format("{:07d}-{:012d}", number, std::llround(time_s * 1e6));
  }

  fs::path folder_;
  WriteSettings settings_;
  std::string log_;
  int num_frames_ = 0;
};

}  // namespace

Result<std::unique_ptr<CaptureWriter>> CreateOpen3d(const fs::path& path,
                                                    const WriteSettings& settings) {
  for (const char* name : {"color", "depth"}) {
    if (Status status = MakeFolder(path / name); !status) return status.error();
  }
  return std::unique_ptr<CaptureWriter>(std::make_unique<WriterOfOpen3d>(path, settings));
}

}  // namespace deepslam::convert
