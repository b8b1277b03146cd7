#include "deepslam/convert/tum_writer.h"

#include <cmath>
#include <fstream>
#include <utility>

#include <fmt/format.h>

#include "deepslam/dataset/image_files.h"

namespace deepslam::convert {
namespace {

namespace fs = std::filesystem;

// 65535 reads back as invalid.
constexpr double kMaxRawDepth = 65534;

Status WriteTextFile(const fs::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  out << text;
  out.close();
  if (!out)
    return Failed(fmt::format("{}: cannot be written; is the disk full or the folder read-only?",
                              file.string()));
  return Ok();
}

RawDepthImage ToRaw(const DepthImage& depth_m, double units_per_m) {
  RawDepthImage raw(depth_m.width(), depth_m.height());
  std::uint16_t* out = raw.data();
  for (const float d : depth_m) {
    const double value = std::round(static_cast<double>(d) * units_per_m);
    *out++ =
        value >= 1 && value <= kMaxRawDepth ? static_cast<std::uint16_t>(value) : std::uint16_t{0};
  }
  return raw;
}

std::string ColourName(int i) { return fmt::format("rgb/{:06d}.jpg", i); }
std::string DepthName(int i) { return fmt::format("depth/{:06d}.png", i); }

}  // namespace

TumWriter::TumWriter(fs::path folder, dataset::CaptureSettings settings)
    : folder_(std::move(folder)), settings_(std::move(settings)) {}

Result<TumWriter> TumWriter::Create(const fs::path& folder,
                                    const dataset::CaptureSettings& settings) {
  const Status camera = dataset::CheckCamera(settings.camera, folder);
  if (!camera) return camera.error();
  std::error_code code;
  if (fs::exists(folder, code) && !(fs::is_directory(folder, code) && fs::is_empty(folder, code))) {
    return InvalidConfig(fmt::format(
        "{}: exists and is not an empty folder; name a new one or remove it", folder.string()));
  }
  for (const char* name : {"rgb", "depth"}) {
    fs::create_directories(folder / name, code);
    if (code)
      return Failed(
          fmt::format("{}: cannot be made ({})", (folder / name).string(), code.message()));
  }
  return TumWriter(folder, settings);
}

Status TumWriter::AddFrame(const Frame& frame, const std::optional<Pose3>& world_from_camera) {
  const PinholeCamera& camera = settings_.camera;
  DEEPSLAM_CHECK(frame.colour.width() == camera.width && frame.colour.height() == camera.height &&
                     frame.depth_m.width() == camera.width &&
                     frame.depth_m.height() == camera.height,
                 "images must have the camera's size");
  const int i = num_frames();
  const Status colour = dataset::WriteColourFile(folder_ / ColourName(i), frame.colour);
  if (!colour) return colour;
  const Status depth = dataset::WriteDepthFile(folder_ / DepthName(i),
                                               ToRaw(frame.depth_m, settings_.depth_units_per_m));
  if (!depth) return depth;
  rows_.push_back({frame.time_s, world_from_camera});
  return Ok();
}

Status TumWriter::Finish() {
  std::string rgb = "# timestamp filename\n";
  std::string depth = rgb;
  std::string both;
  std::string poses = "# timestamp tx ty tz qx qy qz qw (world from colour camera)\n";
  bool has_poses = false;
  for (int i = 0; i < num_frames(); ++i) {
    const Row& row = rows_[static_cast<std::size_t>(i)];
    const std::string time = fmt::format("{:.6f}", row.time_s);
    rgb += fmt::format("{} {}\n", time, ColourName(i));
    depth += fmt::format("{} {}\n", time, DepthName(i));
    both += fmt::format("{} {} {} {}\n", time, ColourName(i), time, DepthName(i));
    if (!row.world_from_camera) continue;
    has_poses = true;
    const Eigen::Vector3d& t = row.world_from_camera->translation_m;
    const Eigen::Quaterniond& q = row.world_from_camera->rotation;
    poses += fmt::format("{} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n",
                         time,
                         t.x(),
                         t.y(),
                         t.z(),
                         q.x(),
                         q.y(),
                         q.z(),
                         q.w());
  }
  std::vector<std::pair<const char*, const std::string*>> files = {
      {"rgb.txt", &rgb}, {"depth.txt", &depth}, {"associations.txt", &both}};
  if (has_poses) files.emplace_back("groundtruth.txt", &poses);
  const std::string settings = dataset::FormatCaptureSettings(settings_);
  files.emplace_back("capture.yaml", &settings);
  for (const auto& [name, text] : files) {
    const Status written = WriteTextFile(folder_ / name, *text);
    if (!written) return written;
  }
  return Ok();
}

}  // namespace deepslam::convert
