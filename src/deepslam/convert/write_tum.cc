#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "deepslam/convert/capture_writer.h"
#include "deepslam/dataset/capture_settings.h"

namespace deepslam::convert {
namespace {

namespace fs = std::filesystem;

// Microseconds as everybody writes them; more digits only where they say more.
std::string FormatTime(double time_s) {
  std::string text = fmt::format("{:.6f}", time_s);
  return std::stod(text) == time_s ? text : fmt::format("{}", time_s);
}

class WriterOfTum final : public CaptureWriter {
 public:
  WriterOfTum(fs::path folder, const WriteSettings& settings)
      : folder_(std::move(folder)), settings_(settings) {}

  [[nodiscard]] Status Add(const WriteFrame& frame) override {
    const std::string colour = fmt::format("rgb/{:06d}{}", frame.number, ColourEnd(frame.colour));
    const std::string depth = fmt::format("depth/{:06d}.png", frame.number);
    const Result<std::string> bytes = ColourBytes(frame.colour);
    if (!bytes) return bytes.error();
    if (Status status = WriteWhole(folder_ / colour, *bytes); !status) return status;
    if (Status status = dataset::WriteDepthFile(folder_ / depth, frame.depth); !status)
      return status;
    const std::string colour_time = FormatTime(frame.colour_time_s);
    const std::string depth_time = FormatTime(frame.depth_time_s);
    rgb_ += fmt::format("{} {}\n", colour_time, colour);
    depth_ += fmt::format("{} {}\n", depth_time, depth);
    both_ += fmt::format("{} {} {} {}\n", colour_time, colour, depth_time, depth);
    if (!frame.world_from_colour) return Ok();
    const Eigen::Vector3d& t = frame.world_from_colour->translation_m;
    const Eigen::Quaterniond& q = frame.world_from_colour->rotation;
    poses_ += fmt::format(
        "{} {} {} {} {} {} {} {}\n", depth_time, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
    return Ok();
  }

  [[nodiscard]] Status Finish() override {
    dataset::CaptureSettings settings;
    settings.camera = settings_.cameras.colour;
    settings.depth_units_per_m = settings_.cameras.depth_units_per_m;
    const std::string yaml = dataset::FormatCaptureSettings(settings);
    using File = std::pair<const char*, const std::string*>;
    for (const auto& [name, text] : {File("rgb.txt", &rgb_),
                                     File("depth.txt", &depth_),
                                     File("associations.txt", &both_),
                                     File("groundtruth.txt", &poses_),
                                     File("capture.yaml", &yaml)}) {
      if (text->empty()) continue;
      if (Status status = WriteWhole(folder_ / name, *text); !status) return status;
    }
    return Ok();
  }

 private:
  fs::path folder_;
  WriteSettings settings_;
  std::string rgb_ = "# timestamp filename\n";
  std::string depth_ = "# timestamp filename\n";
  std::string both_;
  std::string poses_;
};

}  // namespace

Result<std::unique_ptr<CaptureWriter>> CreateTum(const fs::path& path,
                                                 const WriteSettings& settings) {
  for (const char* name : {"rgb", "depth"}) {
    if (Status status = MakeFolder(path / name); !status) return status.error();
  }
  return std::unique_ptr<CaptureWriter>(std::make_unique<WriterOfTum>(path, settings));
}

}  // namespace deepslam::convert
