#include "deepslam/batch/forecast.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <utility>

namespace deepslam::batch {
namespace {

namespace fs = std::filesystem;

// Seconds of the stages on a room of 500 frames of 640 x 480, two threads; for the first capture of
// a batch, before there is anything better.
const std::array<std::pair<const char*, double>, 15> kUsualSeconds = {{{"track", 6.0},
                                                                       {"ground", 0.5},
                                                                       {"layout", 1.0},
                                                                       {"detect", 6.0},
                                                                       {"segment", 0.5},
                                                                       {"associate", 0.5},
                                                                       {"propose", 3.0},
                                                                       {"register", 4.0},
                                                                       {"select", 1.5},
                                                                       {"loops", 1.0},
                                                                       {"optimize", 0.3},
                                                                       {"mesh", 3.0},
                                                                       {"fuse", 3.0},
                                                                       {"export", 1.0},
                                                                       {"report", 2.0}}};
constexpr double kOtherStageSeconds = 1.0;  // for stages that the table above does not name

// Rounded up from a handful of rendered and real rooms.
constexpr std::uintmax_t kBytesPerCapture = 12'000'000;
constexpr std::uintmax_t kBytesPerFrame = 30'000;
constexpr std::uintmax_t kKeptBytesPerCapture = 10'000'000;
constexpr std::uintmax_t kKeptBytesPerFrame = 4'000;
constexpr std::uintmax_t kBytesPerStreamedFrame = 60'000;  // of a recording in one file, at least

bool IsImage(const fs::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension == ".png" || extension == ".jpg" || extension == ".jpeg" ||
         extension == ".ppm" || extension == ".pgm" || extension == ".tif" || extension == ".tiff";
}

std::uintmax_t EstimateFrames(const fs::path& capture) {
  std::error_code error;
  if (!fs::is_directory(capture, error)) {
    const std::uintmax_t size = fs::file_size(capture, error);
    return error ? 0 : size / kBytesPerStreamedFrame;
  }
  std::uintmax_t images = 0, streamed = 0;
  for (fs::recursive_directory_iterator it(capture, error), end; !error && it != end;
       it.increment(error)) {
    if (IsImage(it->path())) {
      ++images;
    } else if (it->path().extension() == ".sens") {
      std::error_code ignored;
      const std::uintmax_t size = fs::file_size(it->path(), ignored);
      if (!ignored) streamed += size / kBytesPerStreamedFrame;
    }
  }
  return std::max(images / 2, streamed);  // a frame is at least a colour and a depth image
}

}  // namespace

std::map<std::string, double> StageShares(std::span<const CaptureRecord> records,
                                          std::span<const std::string> stages) {
  std::map<std::string, double> seconds;
  double sum = 0;
  for (const CaptureRecord& record : records) {
    if (record.state != CaptureState::kDone) continue;
    for (const auto& [stage, stage_s] : record.stage_s) {
      seconds[stage] += stage_s;
      sum += stage_s;
    }
  }
  if (sum <= 0) {
    seconds.clear();
    for (const auto& [stage, usual_s] : kUsualSeconds) seconds[stage] = usual_s;
  }
  std::map<std::string, double> shares;
  sum = 0;
  for (const std::string& stage : stages) {
    const auto it = seconds.find(stage);
    shares[stage] = it == seconds.end() ? kOtherStageSeconds : it->second;
    sum += shares[stage];
  }
  for (auto& [stage, share] : shares) share /= std::max(sum, 1e-9);
  return shares;
}

std::optional<double> SecondsLeft(const CaptureRecord& running,
                                  double elapsed_s,
                                  const std::map<std::string, double>& shares,
                                  std::span<const std::string> stages) {
  double share = 0;
  bool found = false;
  for (const std::string& stage : stages) {
    const auto it = shares.find(stage);
    const double of_stage = it == shares.end() ? 0 : it->second;
    if (stage == running.stage) {
      const double within =
          running.total == 0
              ? 0
              : std::min(1.0,
                         static_cast<double>(running.done) / static_cast<double>(running.total));
      share += of_stage * within;
      found = true;
      break;
    }
    share += of_stage;
  }
  constexpr double kLeastDone = 0.02;  // less says nothing about the rest
  if (!found || share < kLeastDone || elapsed_s <= 0) return std::nullopt;
  return elapsed_s * (1 - share) / share;
}

std::optional<double> SecondsLeft(const BatchState& batch, double now_s) {
  double sum_s = 0;
  int num = 0, unfinished = 0, running = 0;
  double worked_s = 0;  // on the running ones
  for (const CaptureRecord& record : batch.captures) {
    if (record.state == CaptureState::kWaiting || record.state == CaptureState::kInterrupted) {
      ++unfinished;
    } else if (record.state == CaptureState::kRunning) {
      ++unfinished;
      ++running;
      worked_s += std::max(0.0, now_s - static_cast<double>(record.started_s));
    } else if (record.state == CaptureState::kDone && record.ended_s >= batch.started_s) {
      sum_s += record.attempt_s;
      ++num;
    }
  }
  if (num == 0) return std::nullopt;
  const double mean_s = sum_s / num;
  const int at_a_time = std::max(1, batch.jobs > 0 ? batch.jobs : running);
  const double left_s = mean_s * unfinished - std::min(worked_s, mean_s * running);
  return std::max(0.0, left_s / at_a_time);
}

DiskNeed DiskNeedOf(std::uintmax_t num_frames) {
  return {kBytesPerCapture + kBytesPerFrame * num_frames,
          kKeptBytesPerCapture + kKeptBytesPerFrame * num_frames};
}

DiskNeed EstimateDiskNeed(const fs::path& capture) { return DiskNeedOf(EstimateFrames(capture)); }

}  // namespace deepslam::batch
