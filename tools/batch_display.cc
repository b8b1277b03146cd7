#include "batch_display.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>
#include <utility>

#include <fmt/format.h>

#include "batch_capture.h"
#include "console.h"
#include "deepslam/batch/progress_table.h"

namespace deepslam::tools {
namespace {

constexpr auto kDrawInterval = std::chrono::milliseconds(200);  // looks steady, also over a network

batch::TableOptions TerminalSize() {
  batch::TableOptions options;
  winsize size{};
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 && size.ws_row > 0) {
    // The last column stays free: some terminals wrap a line that fills it.
    options.width = size.ws_col - 1;
    options.height = size.ws_row;
  }
  return options;
}

}  // namespace

BatchStyle ParseBatchStyle(std::string_view name) {
  if (name == "table") return BatchStyle::kTable;
  if (name == "lines") return BatchStyle::kLines;
  if (name == "none") return BatchStyle::kNone;
  return ::isatty(STDERR_FILENO) != 0 ? BatchStyle::kTable : BatchStyle::kLines;
}

BatchDisplay::BatchDisplay(BatchStyle style, std::vector<std::string> stages)
    : style_(style), stages_(std::move(stages)) {}

BatchDisplay::~BatchDisplay() { Clear(); }

void BatchDisplay::Clear() {
  if (num_lines_ > 0) fmt::print(stderr, "\033[{}A\033[J", num_lines_);
  std::fflush(stderr);
  num_lines_ = 0;
}

void BatchDisplay::Update(const batch::BatchState& batch) {
  const auto now = std::chrono::steady_clock::now();
  if (style_ != BatchStyle::kTable || (num_lines_ > 0 && now - drawn_ < kDrawInterval)) return;
  drawn_ = now;
  const std::vector<std::string> lines =
      batch::RenderTable(batch, stages_, NowSeconds(), TerminalSize());
  // Over the old table in one piece, so that it does not flicker.
  std::string text = num_lines_ > 0 ? fmt::format("\033[{}A", num_lines_) : std::string();
  for (const std::string& line : lines) text += line + "\033[K\n";
  fmt::print(stderr, "{}\033[J", text);
  std::fflush(stderr);
  num_lines_ = lines.size();
}

void BatchDisplay::Ended(const batch::CaptureRecord& record,
                         std::size_t num_ended,
                         std::size_t num_all) {
  if (style_ == BatchStyle::kNone) return;
  Clear();
  const std::string line = fmt::format("[{}/{}] {}", num_ended, num_all, batch::EndLine(record));
  if (record.state == batch::CaptureState::kFailed) {
    LogError(line);
  } else {
    LogInfo(line);
  }
}

}  // namespace deepslam::tools
