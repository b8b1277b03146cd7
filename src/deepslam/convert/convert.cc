#include "deepslam/convert/convert.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "deepslam/convert/conversion_target.h"
#include "deepslam/convert/other_files.h"
#include "deepslam/dataset/depth_registration.h"

namespace deepslam::convert {
namespace {

namespace fs = std::filesystem;

// Times of today in seconds have steps of a quarter of a microsecond.
constexpr double kTimeStepS = 3e-7;
// What tells two times apart in every layout.
constexpr double kDistinctS = 1e-6;

// Raw depth in the units of the result.
class DepthUnits {
 public:
  DepthUnits(double from_per_m, double to_per_m, bool from_seven_scenes, std::uint16_t no_depth)
      : table_(kSaturatedDepth + 1u) {
    for (std::size_t raw = 0; raw < table_.size(); ++raw) {
      const double value = std::round(static_cast<double>(raw) * to_per_m / from_per_m);
      table_[raw] =
          value >= 1 && value < kSaturatedDepth ? static_cast<std::uint16_t>(value) : no_depth;
    }
    table_[kNoDepth] = no_depth;
    // Elsewhere than in 7-Scenes it is a value as any other, although nobody measured it.
    const bool keeps_saturated = from_per_m == to_per_m && !from_seven_scenes;
    table_[kSaturatedDepth] = keeps_saturated && no_depth == kNoDepth ? kSaturatedDepth : no_depth;
    rounds_ = from_per_m != to_per_m;
    largest_error_m_ = 0.5 / to_per_m;
    for (std::size_t raw = 1; raw + 1 < table_.size(); ++raw) lost_[raw] = table_[raw] == no_depth;
  }

  void Apply(RawDepthImage& depth) {
    for (std::uint16_t& raw : depth) {
      num_lost_ += lost_[raw] ? 1 : 0;
      raw = table_[raw];
    }
  }
  [[nodiscard]] bool rounds() const { return rounds_; }
  [[nodiscard]] double largest_error_m() const { return largest_error_m_; }
  [[nodiscard]] std::size_t num_lost() const { return num_lost_; }

 private:
  std::vector<std::uint16_t> table_;
  std::vector<bool> lost_ = std::vector<bool>(kSaturatedDepth + 1u, false);
  bool rounds_ = false;
  double largest_error_m_ = 0;
  std::size_t num_lost_ = 0;  // pixels whose depth does not fit 16 bits
};

RawDepthImage ToRaw(const DepthImage& depth_m, double units_per_m) {
  RawDepthImage raw(depth_m.width(), depth_m.height());
  std::transform(depth_m.begin(), depth_m.end(), raw.begin(), [&](float d) {
    const double value = std::round(static_cast<double>(d) * units_per_m);
    return value >= 1 && value < kSaturatedDepth ? static_cast<std::uint16_t>(value) : kNoDepth;
  });
  return raw;
}

class Conversion {
 public:
  Conversion(const dataset::Capture& capture, const OutputFormat& format, double depth_units_per_m)
      : capture_(capture),
        format_(format),
        source_(capture.stored->cameras()),
        registers_(!source_.registered() && !format.holds_unregistered),
        settings_{OutputCameras(depth_units_per_m), capture.has_times && format.holds_times},
        units_(source_.depth_units_per_m,
               settings_.cameras.depth_units_per_m,
               capture.format == "7-scenes",
               format.no_depth) {}

  [[nodiscard]] const WriteSettings& settings() const { return settings_; }

  // Whether the target takes frame i; what it leaves out is told.
  bool Takes(std::size_t i) {
    if (!format_.needs_poses || capture_.stored->frames()[i].world_from_colour) return true;
    ++num_without_pose_;
    return false;
  }

  Result<WriteFrame> Make(std::size_t i) {
    const dataset::StoredFrame& stored = capture_.stored->frames()[i];
    WriteFrame frame;
    frame.number = static_cast<std::int64_t>(i);
    frame.colour_time_s = stored.colour_time_s;
    frame.depth_time_s = stored.depth_time_s;
    frame.world_from_colour = stored.world_from_colour;
    if (settings_.has_times && !format_.is_file) MakeTimeDistinct(frame);
    if (Status status = FillColour(i, frame); !status) return status.error();
    if (Status status = FillDepth(i, frame); !status) return status.error();
    Watch(frame);
    return frame;
  }

  ConversionReport Report(int num_frames, int num_skipped, const std::string& first_fault) const {
    ConversionReport report{capture_.format,
                            std::string(format_.name),
                            num_frames,
                            num_skipped,
                            num_poses_,
                            settings_.cameras,
                            {},
                            {}};
    TellFrames(report, first_fault);
    TellTimes(report);
    TellPoses(report);
    TellDepth(report);
    TellColour(report);
    if (!format_.remark.empty()) report.notes.emplace_back(format_.remark);
    if (const std::vector<std::string> others = OtherFiles(capture_.path); !others.empty()) {
      report.losses.push_back(
          fmt::format("{} of the source: only frames, cameras and poses are converted",
                      fmt::join(others, ", ")));
    }
    return report;
  }

 private:
  [[nodiscard]] dataset::CaptureCameras OutputCameras(double depth_units_per_m) const {
    dataset::CaptureCameras cameras = source_;
    if (registers_) {
      cameras.colour = dataset::FrameCamera(source_);
      cameras.depth = cameras.colour;
      cameras.colour_from_depth = Pose3();
    }
    if (depth_units_per_m > 0) cameras.depth_units_per_m = depth_units_per_m;
    if (format_.fixed_units_per_m > 0) cameras.depth_units_per_m = format_.fixed_units_per_m;
    return cameras;
  }

  Status FillColour(std::size_t i, WriteFrame& frame) {
    Result<dataset::StoredColour> stored = capture_.stored->ReadColour(i);
    if (!stored) return stored.error();
    const int reduction = registers_ ? dataset::ColourReduction(source_) : 1;
    // Decoded in any case: what cannot be decoded is no frame, and must not be passed on.
    dataset::StoredColour kept = *stored;
    Result<ColourImage> pixels = dataset::DecodeStored(*std::move(stored), source_.colour);
    if (!pixels) return pixels.error();
    const bool as_png = format_.colour_must_be_png && kept.codec == dataset::ImageCodec::kJpeg;
    if (reduction > 1) {
      frame.colour.pixels = dataset::ReduceColour(*pixels, reduction);
    } else if (as_png || kept.codec == dataset::ImageCodec::kOther) {
      frame.colour.pixels = *std::move(pixels);
      ++num_encoded_;
    } else {
      frame.colour = std::move(kept);
    }
    frame.colour.name = kept.name;
    return Ok();
  }

  Status FillDepth(std::size_t i, WriteFrame& frame) {
    if (registers_) {
      const Result<Frame> read = capture_.frames->ReadDepth(FrameIdx{static_cast<int>(i)});
      if (!read) return read.error();
      frame.depth = ToRaw(read->depth_m, settings_.cameras.depth_units_per_m);
      return Ok();
    }
    Result<RawDepthImage> raw = capture_.stored->ReadDepth(i);
    if (!raw) return raw.error();
    frame.depth = *std::move(raw);
    units_.Apply(frame.depth);
    return Ok();
  }

  // Readers of lists drop frames that repeat a time.
  void MakeTimeDistinct(WriteFrame& frame) {
    double shift_s = 0;
    while (!times_s_.insert(frame.depth_time_s + shift_s).second) shift_s += kDistinctS;
    if (shift_s > 0) ++num_shifted_;
    frame.colour_time_s += shift_s;
    frame.depth_time_s += shift_s;
  }

  // What is only known when all frames have gone by.
  void Watch(const WriteFrame& frame) {
    for (const double time_s : {frame.colour_time_s, frame.depth_time_s}) {
      const double rounded_s = std::round(time_s * 1e6) / 1e6;
      largest_time_error_s_ = std::max(largest_time_error_s_, std::abs(time_s - rounded_s));
      has_negative_time_ = has_negative_time_ || time_s < 0;
    }
    if (last_time_s_ && frame.depth_time_s <= *last_time_s_) ++num_repeated_;
    last_time_s_ = frame.depth_time_s;
    if (!frame.world_from_colour) return;
    ++num_poses_;
    const Eigen::Vector3d& t = frame.world_from_colour->translation_m;
    largest_pose_error_m_ =
        std::max(largest_pose_error_m_, (t - t.cast<float>().cast<double>()).norm());
  }

  void TellFrames(ConversionReport& report, const std::string& first_fault) const {
    if (report.num_skipped == 0) return;
    report.losses.push_back(fmt::format("{} frames cannot be read and were left out; the first: {}",
                                        report.num_skipped,
                                        first_fault));
  }

  void TellTimes(ConversionReport& report) const {
    if (!capture_.has_times) {
      report.notes.emplace_back("the source has no times; its frames are taken for 30 per second");
    } else if (!format_.holds_times) {
      report.losses.push_back(fmt::format(
          "times: {} has no place for them, readers take 30 frames per second", format_.name));
    } else if (format_.times_in_microseconds) {
      if (largest_time_error_s_ > kTimeStepS)
        report.losses.push_back(fmt::format("times are rounded to microseconds (by up to {:.2g} s)",
                                            largest_time_error_s_));
      if (has_negative_time_) report.losses.emplace_back("times before 0 became 0");
    }
    if (num_shifted_ > 0) {
      report.losses.push_back(fmt::format(
          "{} frames repeat the time of another; theirs were put later by microseconds, since "
          "readers drop repeated ones",
          num_shifted_));
    }
    if (settings_.has_times && num_repeated_ > 0 && !format_.is_file) {
      report.losses.push_back(fmt::format(
          "{} frames are not later than the one before; readers may sort by time", num_repeated_));
    }
  }

  void TellPoses(ConversionReport& report) const {
    if (num_without_pose_ > 0) {
      report.losses.push_back(
          fmt::format("{} frames without a pose were left out: {} needs one of each",
                      num_without_pose_,
                      format_.name));
    }
    if (num_poses_ == 0) return;
    if (capture_.format == "tum" || capture_.format == "eth3d")
      report.notes.emplace_back("poses are those of groundtruth.txt at the times of the frames");
    if (format_.poses_in_floats) {
      report.losses.push_back(
          fmt::format("poses are rounded to 32-bit floats (positions by up to {:.2g} m, rotations "
                      "by up to 1e-7)",
                      largest_pose_error_m_));
    }
    const int num_lost = report.num_frames - num_poses_;
    if (num_lost > 0 && format_.name == "tum") {
      report.losses.push_back(fmt::format(
          "{} frames have no pose; readers of groundtruth.txt may interpolate one where "
          "the gap is short",
          num_lost));
    }
    if (capture_.format == "icl-nuim")
      report.notes.emplace_back("the trajectory is that of the images' world: mirrored in y");
  }

  void TellDepth(ConversionReport& report) const {
    if (!format_.holds_depth) {
      report.losses.push_back(fmt::format("depth images: {} has no place for them", format_.name));
      return;
    }
    const dataset::CaptureCameras& cameras = settings_.cameras;
    if (registers_) {
      report.losses.push_back(fmt::format(
          "depth was registered to colour: {} x {} px of its own camera became {} x {} px of the "
          "colour camera's",
          source_.depth.width,
          source_.depth.height,
          cameras.depth.width,
          cameras.depth.height));
    } else if (!cameras.registered()) {
      report.notes.emplace_back(
          "depth is not registered to colour; both cameras and what lies between are written");
    }
    if (units_.rounds()) {
      report.losses.push_back(
          fmt::format("depth is in units of 1/{} m instead of 1/{} m: rounded by up to {:.2g} m",
                      cameras.depth_units_per_m,
                      source_.depth_units_per_m,
                      units_.largest_error_m()));
    }
    if (units_.num_lost() > 0) {
      report.losses.push_back(fmt::format(
          "depth of {} pixels does not fit the units and became invalid", units_.num_lost()));
    }
    if (capture_.format == "stray")
      report.losses.emplace_back("confidence maps: depth below the least confidence was removed");
    if ((capture_.format == "7-scenes") != (format_.no_depth == kSaturatedDepth)) {
      report.notes.push_back(
          fmt::format("pixels without depth have the value {}", format_.no_depth));
    }
    if (format_.name == "open3d" && cameras.depth_units_per_m != 1000) {
      report.notes.push_back(fmt::format(
          "the depth scale {} lies in config.json: programs that take 1000 for granted have to be "
          "told (or --depth-units 1000)",
          cameras.depth_units_per_m));
    }
  }

  void TellColour(ConversionReport& report) const {
    const PinholeCamera& colour = settings_.cameras.colour;
    if (colour.width != source_.colour.width) {
      report.losses.push_back(fmt::format("colour was reduced from {} x {} to {} x {} px",
                                          source_.colour.width,
                                          source_.colour.height,
                                          colour.width,
                                          colour.height));
    } else if (num_encoded_ > 0) {
      report.notes.push_back(fmt::format(
          "{} colour images were decoded and stored as PNG, the pixels unchanged", num_encoded_));
    } else {
      report.notes.emplace_back("colour images are the source's, byte by byte");
    }
  }

  const dataset::Capture& capture_;
  const OutputFormat& format_;
  dataset::CaptureCameras source_;
  bool registers_;
  WriteSettings settings_;
  DepthUnits units_;

  int num_poses_ = 0;
  int num_without_pose_ = 0;
  int num_encoded_ = 0;
  int num_repeated_ = 0;
  double largest_time_error_s_ = 0;
  double largest_pose_error_m_ = 0;
  bool has_negative_time_ = false;
  std::optional<double> last_time_s_;
  std::set<double> times_s_;
  int num_shifted_ = 0;
};

// "out/" and "out" are one result.
fs::path WithoutSlash(const fs::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

// Whether the format can hold what is wanted of it.
Status CheckWanted(const dataset::Capture& capture,
                   const OutputFormat& format,
                   double depth_units_per_m) {
  if (format.fixed_units_per_m > 0 && depth_units_per_m > 0 &&
      depth_units_per_m != format.fixed_units_per_m) {
    return InvalidConfig(fmt::format("depth units of {} per metre: {} always has {}",
                                     depth_units_per_m,
                                     format.name,
                                     format.fixed_units_per_m));
  }
  if (!format.needs_poses || capture.has_poses) return Ok();
  return InvalidInput(fmt::format(
      "{}: has no poses, which {} needs; map it, and give the run's folder (--trajectory "
      "WORKSPACE)",
      capture.path.string(),
      format.name));
}

nlohmann::ordered_json ToJson(const PinholeCamera& camera) {
  return {{"width", camera.width},
          {"height", camera.height},
          {"fx", camera.fx},
          {"fy", camera.fy},
          {"cx", camera.cx},
          {"cy", camera.cy}};
}

}  // namespace

std::string FormatReport(const ConversionReport& report) {
  nlohmann::ordered_json json = {{"format", "deepslam/conversion"},
                                 {"version", 1},
                                 {"from", report.from},
                                 {"to", report.to},
                                 {"num_frames", report.num_frames},
                                 {"num_skipped", report.num_skipped},
                                 {"num_poses", report.num_poses},
                                 {"camera", ToJson(report.cameras.colour)},
                                 {"depth_units_per_m", report.cameras.depth_units_per_m},
                                 {"losses", report.losses},
                                 {"notes", report.notes}};
  if (!report.cameras.registered()) json["depth_camera"] = ToJson(report.cameras.depth);
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

Result<ConversionReport> ConvertCapture(const dataset::Capture& capture,
                                        const fs::path& to,
                                        const OutputFormat& format,
                                        double depth_units_per_m,
                                        const ConversionProgress& progress) {
  std::error_code code;
  // An empty folder that is there gives its place to the result: itself, not a link to it or ".".
  const fs::path target = fs::is_directory(to, code) ? fs::canonical(to, code) : WithoutSlash(to);
  if (Status status = CheckTarget(target, format); !status) return status.error();
  if (Status status = CheckWanted(capture, format, depth_units_per_m); !status)
    return status.error();
  Aside aside(target);
  if (Status status = MakeFolder(format.is_file && target.has_parent_path() ? target.parent_path()
                                 : format.is_file                           ? fs::path(".")
                                                                            : aside.path());
      !status) {
    return status.error();
  }
  Conversion conversion(capture, format, depth_units_per_m);
  Result<std::unique_ptr<CaptureWriter>> writer =
      format.create(aside.path(), conversion.settings());
  if (!writer) return writer.error();
  const std::size_t num_frames = capture.stored->frames().size();
  int num_written = 0;
  int num_skipped = 0;
  std::string first_fault;
  for (std::size_t i = 0; i < num_frames; ++i) {
    if (!conversion.Takes(i)) continue;
    const Result<WriteFrame> frame = conversion.Make(i);
    if (frame) {
      if (Status status = (*writer)->Add(*frame); !status) return status.error();
      ++num_written;
    } else if (num_skipped++ == 0) {
      first_fault = frame.error().message;
    }
    if (progress && !progress(i + 1, num_frames)) return Interrupted();
  }
  if (num_written == 0) return InvalidInput("no frame can be read; the first: " + first_fault);
  if (Status status = (*writer)->Finish(); !status) return status.error();
  ConversionReport report = conversion.Report(num_written, num_skipped, first_fault);
  const std::string json = FormatReport(report);
  if (!format.is_file) {
    if (Status status = WriteWhole(aside.path() / "conversion.json", json); !status)
      return status.error();
  }
  writer->reset();
  if (Status status = aside.Commit(); !status) return status.error();
  if (format.is_file) {
    if (Status status = WriteWhole(target.string() + ".conversion.json", json); !status)
      return status.error();
  }
  return report;
}

}  // namespace deepslam::convert
