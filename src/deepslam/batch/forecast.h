// How long a batch will take, and how much it will write. Guesses, for people alone.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "deepslam/batch/batch_state.h"
#include "deepslam/core/result.h"

namespace deepslam::batch {

// Share of each stage in the time of a whole chain; the sum is 1. From the records of captures that
// are done, else from what was measured on rooms of 500 frames.
[[nodiscard]] std::map<std::string, double> StageShares(std::span<const CaptureRecord> records,
                                                        std::span<const std::string> stages);

// Seconds until a running capture is done; nothing before there is something to go by. `stages` are
// those of the chain, in order.
[[nodiscard]] std::optional<double> SecondsLeft(const CaptureRecord& running,
                                                double elapsed_s,
                                                const std::map<std::string, double>& shares,
                                                std::span<const std::string> stages);

// Seconds until the batch is done, by the mean of the captures that are; nothing before the first.
// Captures that were done before this call do not count.
[[nodiscard]] std::optional<double> SecondsLeft(const BatchState& batch, double now_s);

// Bytes that the workspace of a capture will take: by its frames, or where it was not opened by the
// number of its images or the size of its file. Rather too much than too little.
struct DiskNeed {
  std::uintmax_t whole = 0;  // while the capture is worked on
  std::uintmax_t kept = 0;   // with --keep final
};
[[nodiscard]] DiskNeed DiskNeedOf(std::uintmax_t num_frames);
[[nodiscard]] DiskNeed EstimateDiskNeed(const std::filesystem::path& capture);

}  // namespace deepslam::batch
