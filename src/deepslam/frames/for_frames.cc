#include "deepslam/frames/for_frames.h"

#include <array>
#include <cstddef>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/parallel_ahead.h"

namespace deepslam {
namespace {

constexpr std::size_t kFramesAhead = 8;  // 2 MB each

}  // namespace

Status ForFrames(const FrameSource& frames,
                 std::span<const FrameIdx> wanted,
                 Progress& progress,
                 const std::function<Status(const Frame&)>& use,
                 FrameContent content) {
  std::array<std::optional<Result<Frame>>, kFramesAhead> read;
  Status status;
  const auto use_one = [&](std::size_t n) -> Status {
    if (progress.StopRequested()) return Interrupted();
    const Result<Frame> frame = *std::exchange(read[n % kFramesAhead], std::nullopt);
    if (n % kFramesAhead == 0) progress.Report(n, wanted.size());
    if (frame.ok()) return use(*frame);
    progress.Warn(fmt::format("frame {} skipped: {}", wanted[n].value, frame.error().message));
    return Ok();
  };
  ParallelAhead(
      wanted.size(),
      kFramesAhead,
      [&](std::size_t n) {
        read[n % kFramesAhead] =
            content == FrameContent::kDepth ? frames.ReadDepth(wanted[n]) : frames.Read(wanted[n]);
      },
      [&](std::size_t n) {
        status = use_one(n);
        return status.ok();
      });
  if (status.ok()) progress.Report(wanted.size(), wanted.size());
  return status;
}

}  // namespace deepslam
