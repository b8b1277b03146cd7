#include "deepslam/layouts/open_capture.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/freed_memory.h"
#include "deepslam/core/sha256.h"
#include "deepslam/core/utf8.h"
#include "deepslam/dataset/capture_frame_source.h"
#include "deepslam/dataset/file_frames.h"
#include "deepslam/layouts/layout.h"
#include "deepslam/layouts/look_at_capture.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

constexpr int kNumProbedFrames = 8;  // spread over the capture: all being empty is no chance

// Refuses captures of which no looked-at frame can be used: wrong camera, wrong units, wrong files.
Status Probe(const FrameSource& frames, const fs::path& folder) {
  const int num_probes = std::min(kNumProbedFrames, frames.num_frames());
  std::optional<Error> first_error;
  int num_readable = 0;
  for (int i = 0; i < num_probes; ++i) {
    const int idx =
        static_cast<int>(static_cast<std::int64_t>(i) * frames.num_frames() / num_probes);
    const Result<Frame> frame = frames.Read(FrameIdx{idx});
    if (!frame) {
      if (!first_error) first_error = frame.error();
      continue;
    }
    ++num_readable;
    if (std::any_of(frame->depth_m.begin(), frame->depth_m.end(), [](float d) { return d > 0; }))
      return Ok();
  }
  if (num_readable > 0) {
    return InvalidInput(
        fmt::format("{}: no valid depth (above 0, up to {} m) in any of {} frames looked at; check "
                    "the depth images and 'depth_units_per_m' in capture.yaml",
                    folder.string(),
                    kMaxDepthM,
                    num_readable));
  }
  return InvalidInput(fmt::format("{}: none of {} frames looked at can be used; the first: {}",
                                  folder.string(),
                                  num_probes,
                                  first_error->message));
}

// "capture/" and "." have no file name of their own; names out of old archives may be no UTF-8,
// which nothing that is written about the capture could hold.
std::string NameOf(const fs::path& path) {
  std::error_code code;
  const fs::path full = fs::weakly_canonical(path, code);
  return ToValidUtf8((code ? path : full).filename().string());
}

Result<LayoutSource> ReadSource(const fs::path& path) {
  LayoutSource source{path, {}, std::nullopt};
  source.settings.format.clear();
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) return source;
  Result<std::optional<std::string>> text = dataset::ReadOptional(path / kSettingsName);
  if (!text) return text.error();
  source.settings_text = *std::move(text);
  if (!source.settings_text) return source;
  Result<dataset::CaptureSettings> settings =
      dataset::ParseCaptureSettings(*source.settings_text, path / kSettingsName);
  if (!settings) return settings.error();
  source.settings = *std::move(settings);
  return source;
}

// Every n-th frame is another capture than all of them.
void TakeAtMost(int max_frames, dataset::Capture& capture) {
  const std::size_t num_frames = capture.stored->frames().size();
  const auto most = static_cast<std::size_t>(max_frames);
  if (num_frames <= most) return;
  const std::size_t step = (num_frames + most - 1) / most;
  capture.stored = capture.stored->Every(step);
  capture.content_hash = Sha256Hex(fmt::format("{} every {}\n", capture.content_hash, step));
  capture.warnings.push_back(
      fmt::format("{}: one frame in {} is taken, {} of {}: at most {} are; state another "
                  "'max_frames' in capture.yaml (memory grows with it)",
                  capture.path.string(),
                  step,
                  capture.stored->frames().size(),
                  num_frames,
                  most));
}

// Looks at frames, and says what nobody has confirmed.
void Doubt(const std::vector<std::string>& of_layout,
           const LayoutSource& source,
           const std::string& poses_file,
           dataset::Capture& capture) {
  capture.doubts = of_layout;
  for (const std::string& field : source.settings.assumed) {
    capture.doubts.push_back(fmt::format(
        "{}: '{}' is assumed, nobody has confirmed it; correct it where it is wrong, and take it "
        "out of 'assumed'",
        (source.path / kSettingsName).string(),
        field));
  }
  std::ranges::move(DoubtsOf(capture), std::back_inserter(capture.doubts));
  std::ranges::copy(capture.doubts, std::back_inserter(capture.warnings));
  if (!capture.has_poses) return;
  capture.poses_fault = FaultOfPoses(capture, poses_file);
  if (!capture.poses_fault.empty()) capture.warnings.push_back(capture.poses_fault);
}

}  // namespace

Result<dataset::Capture> OpenCapture(const fs::path& path, FramesTaken taken) {
  std::error_code ignored;
  if (!fs::exists(path, ignored))
    return InvalidInput(
        fmt::format("{}: folder is missing; name a capture's folder", path.string()));
  const Result<LayoutSource> source = ReadSource(path);
  if (!source) return source.error();
  const Result<const Layout*> layout = ChooseLayout(path, source->settings.format);
  if (!layout) return layout.error();
  Result<OpenedLayout> opened = (*layout)->open(*source);
  if (!opened) return opened.error();

  dataset::Capture capture;
  capture.stored = dataset::RectifyFrames(std::move(opened->frames), std::move(opened->optics));
  const auto faults = std::make_shared<dataset::ReadFaults>();
  capture.faults = faults;
  capture.path = path;
  capture.name = NameOf(path);
  capture.format = (*layout)->name;
  capture.content_hash = std::move(opened->content_hash);
  capture.warnings = std::move(opened->warnings);
  capture.warnings.insert(
      capture.warnings.end(), source->settings.warnings.begin(), source->settings.warnings.end());
  capture.has_times = opened->has_times;
  if (taken == FramesTaken::kAtMostMaxFrames)
    TakeAtMost(source->settings.max_frames.value_or(dataset::kMaxFrames), capture);
  capture.frames = dataset::MakeCaptureFrameSource(capture.stored, faults);
  capture.has_poses = std::ranges::any_of(capture.stored->frames(), [](const auto& frame) {
    return frame.world_from_colour.has_value();
  });
  ReturnFreedMemory(kMostHeldBytes);  // of long lists
  const Status usable = Probe(*capture.frames, path);
  if (usable) Doubt(opened->doubts, *source, opened->poses_file, capture);
  if (const std::optional<Error> fault = faults->first()) return *fault;
  if (!usable) return usable.error();
  return capture;
}

}  // namespace deepslam::layouts
